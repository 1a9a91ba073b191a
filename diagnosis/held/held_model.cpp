// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held/held_model.h"

#include <algorithm>
#include <cmath>

#include "calibration/model/extension.h"
#include "factors/effects/change.h"
#include "factors/prior_factor.h"

namespace magimu {
namespace {

constexpr double kDipSigma = 1.0, kHeadingSigma = 1.0;  // rad: as good as free
// Standard deviations that hold a parameter, in its unit: far below what any recording tells, far
// above rounding.
constexpr double kHeldGyr = 1e-9, kHeldAcc = 1e-6, kHeldMag = 1e-5, kHeldOther = 1e-8;
constexpr double kHeldEffect = 1e-6;  // of its prior

class WithPrior final : public Effect {
 public:
  WithPrior(std::shared_ptr<const Effect> effect, VectorXd sigma)
      : Effect(effect->description()), effect_(std::move(effect)), sigma_(std::move(sigma)) {}
  void jacobian(const SampleState& state, const VectorXd& theta, EffectJacobian J) const override {
    effect_->jacobian(state, theta, J);
  }
  Vector3 term(const SampleState& state, const VectorXd& theta) const override {
    return effect_->term(state, theta);
  }
  VectorXd prior_sigma(double) const override { return sigma_; }

 private:
  std::shared_ptr<const Effect> effect_;
  VectorXd sigma_;
};

template <class V>
void hold_at(FactorGraph& graph, const Values& known, Key key, double sigma) {
  graph.add(
      PriorFactor<V>(key, known.at<V>(key), Noise<VariableTraits<V>::kTangent>::isotropic(sigma)));
}

void hold_parameter(FactorGraph& graph, const Values& known, Key key, double gyr_sigma) {
  if (key == key::gyr_bias) {
    hold_at<Vector3>(graph, known, key, gyr_sigma);
  } else if (key == key::acc_bias) {
    hold_at<Vector3>(graph, known, key, kHeldAcc);
  } else if (key == key::gyr_matrix) {
    hold_at<GyroMatrix>(graph, known, key, kHeldOther);
  } else if (key.symbol == key::distortion.symbol) {
    hold_at<Matrix3>(graph, known, key, kHeldMag);
  } else if (key.symbol == key::mag_bias.symbol) {
    hold_at<Vector3>(graph, known, key, kHeldMag);
  } else if (key.symbol == key::mag_time_offset_of(0).symbol) {
    hold_at<double>(graph, known, key, kHeldOther);
  }
}

VectorXd constant(Eigen::Index n, double value) { return VectorXd::Constant(n, value); }

}  // namespace

bool belongs_to_recording(const std::string& effect) {
  static const char* const names[] = {"hard_iron_drift",    "field_drift",       "acc_bias_drift",
                                      "field_gradient",     "stationary_source", "gyro_bias_drift",
                                      "mains_interference", "mag_own_clock",     "field_departure",
                                      "mag_gain_drift",     "gyro_gain_drift",   "acc_gain_drift"};
  return is_change(effect) ||
         std::find(std::begin(names), std::end(names), effect) != std::end(names);
}

VectorXd sizes_found(const Effect& effect, const VectorXd& theta) {
  VectorXd out(theta.size());
  const auto& p = effect.description().parameters;
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    double squares = 0.0, count = 0.0;
    for (Eigen::Index j = 0; j < theta.size(); ++j) {
      if (p[std::size_t(j)].unit != p[std::size_t(i)].unit) continue;
      squares += theta[j] * theta[j];
      count += 1.0;
    }
    out[i] = std::max(std::sqrt(squares / count), 1e-9 * p[std::size_t(i)].prior_sigma);
  }
  return out;
}

std::shared_ptr<const Effect> with_prior(std::shared_ptr<const Effect> effect,
                                         const VectorXd& sigma) {
  return std::make_shared<WithPrior>(std::move(effect), sigma);
}

std::vector<KnownEffect> known_effects(const ExtendedModel& model) {
  std::vector<KnownEffect> out;
  const auto keys = effect_keys(model.spec.effects);
  for (std::size_t e = 0; e < keys.size(); ++e) {
    const auto& effect = model.spec.effects[e];
    const VectorXd theta = effect_parameters(model.parameters, keys[e]);
    if (effect->name() == "field_departure") continue;  // each recording has positions of its own
    if (!belongs_to_recording(effect->name())) {
      out.push_back({effect, theta, true});
    } else if (effect->name() == "gyro_bias_drift") {  // its prior is the density found
      out.push_back({effect, VectorXd::Zero(theta.size()), false});
    } else {
      out.push_back({with_prior(effect, sizes_found(*effect, theta)), theta, false});
    }
  }
  return out;
}

std::vector<Integrated> hold(const ExtendedModel& model, const std::vector<KnownEffect>& effects,
                             double duration_s, ModelSpec& spec, Values& start) {
  std::vector<Integrated> free;
  spec.effects.clear();
  spec.extended.clear();
  for (const KnownEffect& k : effects) spec.effects.push_back(k.effect);
  const std::vector<std::vector<Key>> keys = effect_keys(spec.effects);

  double gyr_sigma = kHeldGyr;
  Values known;
  std::vector<double> held_sigma;  // of the effects' parameters
  std::vector<Key> held_keys;
  for (std::size_t e = 0; e < keys.size(); ++e) {
    const KnownEffect& k = effects[e];
    const VectorXd sigma = k.effect->prior_sigma(duration_s);
    if (k.effect->name() == "gyro_bias_drift") {
      gyr_sigma = std::max(gyr_sigma, sigma[0]);
      free.push_back(
          {key::gyr_bias, model.parameters.at<Vector3>(key::gyr_bias), constant(3, gyr_sigma)});
    }
    for (std::size_t i = 0; i < keys[e].size(); ++i) {
      const auto j = Eigen::Index(i);
      known.insert(keys[e][i], k.theta[j]);
      if (k.held) {
        held_keys.push_back(keys[e][i]);
        held_sigma.push_back(kHeldEffect * sigma[j]);
      } else {
        free.push_back({keys[e][i], constant(1, 0.0), constant(1, sigma[j])});
      }
    }
  }
  for (const Values::Slot& s : model.parameters.slots()) {
    const bool own = s.key.symbol == key::effect(0).symbol || s.key.symbol == key::dip.symbol ||
                     s.key.symbol == key::lever_arm_of(0).symbol;
    if (!own) known.insert_from(model.parameters, s.key);
  }
  Values all;
  for (const Values::Slot& s : start.slots()) {
    if (s.key.symbol == key::effect(0).symbol) continue;
    all.insert_from(known.contains(s.key) ? known : start, s.key);
  }
  for (const Values::Slot& s : known.slots()) {
    if (!all.contains(s.key)) all.insert_from(known, s.key);
  }
  start = all;
  const double dip = start.at<double>(key::dip);
  const Rot3 first = start.at<Rot3>(R(0));
  free.push_back({key::dip, constant(1, dip), constant(1, kDipSigma)});
  if (is_moved(spec.motion)) {
    const bool travels = spec.motion == MotionModel::kTravelling;
    free.push_back({key::lever_arm_of(0), constant(3, 0.0),
                    constant(3, travels ? kOwnVelocityPriorSigma : kLeverArmPriorSigma)});
  }
  spec.also = [=](FactorGraph& graph) {
    for (const Values::Slot& s : known.slots()) hold_parameter(graph, known, s.key, gyr_sigma);
    for (std::size_t i = 0; i < held_keys.size(); ++i) {
      hold_at<double>(graph, known, held_keys[i], held_sigma[i]);
    }
    graph.add(PriorFactor<double>(key::dip, dip, Noise<1>::isotropic(kDipSigma)));
    graph.add(PriorFactor<Rot3>(R(0), first, Noise<3>::isotropic(kHeadingSigma)));
  };
  return free;
}

}  // namespace magimu
