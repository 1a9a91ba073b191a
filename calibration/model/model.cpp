// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/model/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "calibration/model/extension.h"
#include "calibration/model/gathered.h"
#include "calibration/model/gyr_matrix_prior.h"
#include "calibration/motion/acc_jitter.h"
#include "calibration/motion/bridged_gaps.h"
#include "factors/accelerometer_factor.h"
#include "factors/delayed_magnetometer_factor.h"
#include "factors/gyroscope_factor.h"
#include "factors/magnetometer_factor.h"
#include "factors/preintegrated_gyroscope_factor.h"
#include "factors/preintegrated_imu_factor.h"
#include "factors/prior_factor.h"
#include "factors/reach_factor.h"
#include "graph/extended_batch.h"
#include "graph/numerical_error.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

// Of the gyroscope's scale, and of the angles of its axes to the accelerometer's, rad: data sheets.
constexpr double kGyrScalePriorSigma = 0.03, kGyrAxesPriorSigma = 1.0 * kDegree;
constexpr double kOffsetPriorSigma = 0.1;  // s: longer lags are another kind of fault

// more: a variance that is added.
Noise<3> noise_of_mean(double density, double rate_hz, const NodeMean& mean, double more = 0.0) {
  const double sigma = density * std::sqrt(rate_hz / mean.independent);
  return Noise<3>::isotropic(more > 0.0 ? std::sqrt(sigma * sigma + more) : sigma);
}

// One recording being put into the graph.
struct Part {
  const Recording& recording;
  const NodePlan& plan;
  const GatheredSamples& gathered;
  int index;  // of the recording
  const ModelSpec& spec;
  const ExtendedRecording* extended;  // null without effects

  const EffectColumns* columns(Sensor channel) const {
    return extended == nullptr ? nullptr : &extended->columns[std::size_t(channel)];
  }
  int nodes() const { return int(plan.t.size()); }
  // The most factors of one type.
  std::size_t of_all_magnetometers() const { return plan.t.size() * recording.mag.size(); }
  bool measures(int i) const { return i > 0 || !plan.continues; }
  int id(int i) const { return plan.first + i; }
};

// What make() returns: a factor or its noise, of a sensor about a node. Where the samples there
// permit none (no time passes between two nodes, or numbers are not finite), sensor and time are
// named.
template <class Make>
auto made_of_samples(const Part& part, const std::string& sensor, int node, const Make& make) {
  try {
    return make();
  } catch (const std::invalid_argument& error) {
    throw NumericalError(fmt::format("the samples of {} at {:.3f} s of {} make no factor: {}",
                                     sensor, part.plan.t[std::size_t(node)], part.recording.name,
                                     error.what()));
  }
}

// Reserves memory for so many factors of a type before the first is added.
template <class F>
void reserve(FactorGraph& graph, std::size_t factors) {
  std::vector<F>& all = graph.mutable_factors<F>();
  if (all.empty()) all.reserve(factors);
}

// Takes factors of one type for the graph, with the columns of the effects on their channels.
template <class F>
class Collector {
 public:
  using Gain = typename ExtendedBatch<F>::Gain;

  // expected: number of factors to reserve memory for.
  Collector(FactorGraph& graph, const Part& part, std::initializer_list<Sensor> channels,
            std::size_t expected)
      : graph_(graph), expected_(expected) {
    std::vector<Key> keys;
    for (const Sensor c : channels) {
      if (part.extended == nullptr) break;
      const auto& own = part.extended->keys[std::size_t(c)];
      keys.insert(keys.end(), own.begin(), own.end());
    }
    if (keys.empty()) return;
    VectorXd theta(Eigen::Index(keys.size()));
    Eigen::Index next = 0;
    for (const Sensor c : channels) {
      const VectorXd& own = part.extended->theta[std::size_t(c)];
      theta.segment(next, own.size()) = own;
      next += own.size();
    }
    batch_ = std::make_unique<ExtendedBatch<F>>(keys, theta);
    on_demand_ = part.gathered.on_demand();
    batch_->reserve(part.nodes(), !on_demand_);
  }
  Collector(const Collector&) = delete;
  Collector& operator=(const Collector&) = delete;
  // After the last factor.
  void finish() {
    if (!batch_ || batch_->size() == 0) return;
    if (on_demand_) {
      batch_->find_gains_with(std::move(gains_));
      graph_.add_batch(std::move(batch_));
      return;
    }
    parallel::for_each(std::size_t(batch_->size()),
                       [this](std::size_t i) { batch_->gain(int(i)) = gains_[i](); });
    graph_.add_batch(std::move(batch_));
  }

  bool extended() const { return batch_ != nullptr; }
  // gain: a function that returns the factor's gain. It is called by finish() or on demand, by
  // several threads; without effects it is not called.
  template <class GainOf>
  void add(const F& factor, const GainOf& gain) {
    if (batch_) {
      on_demand_ ? batch_->add_without_gain(factor) : batch_->add(factor);
      gains_.push_back(gain);
    } else {
      reserve<F>(graph_, expected_);
      graph_.add(factor);
    }
  }

 private:
  FactorGraph& graph_;
  std::size_t expected_;
  std::unique_ptr<ExtendedBatch<F>> batch_;
  bool on_demand_ = false;
  std::vector<std::function<Gain()>> gains_;
};

void add_accelerometer(FactorGraph& graph, const Part& part) {
  const std::vector<NodeMean>& of_nodes = part.gathered.motion(part.index).acc;
  const std::vector<double>& rounding = part.gathered.motion(part.index).acc_rounding;
  const double rate =
      part.spec.acc_rate_hz > 0.0 ? part.spec.acc_rate_hz : part.recording.acc.rate_hz();
  const Vector3 g_n = gravity_n(part.spec.gravity);
  Collector<MeanAccelerometerFactor> means(graph, part, {Sensor::kAcc}, part.plan.t.size());
  for (int i = 0; i < part.nodes(); ++i) {
    const NodeMean& b = of_nodes[std::size_t(i)];
    if (b.count == 0 || !part.measures(i)) continue;
    const Key pose = R(part.id(i));
    const Noise<3> noise = made_of_samples(part, "the accelerometer", i, [&] {
      return noise_of_mean(part.spec.noise.acc, rate, b,
                           rounding.empty() ? 0.0 : rounding[std::size_t(i)]);
    });
    if (b.at_node && !means.extended()) {
      graph.add(AccelerometerFactor(pose, key::acc_bias, b.mean, g_n, noise));
    } else {
      means.add(
          MeanAccelerometerFactor(pose, key::acc_bias, b.mean, b.C, g_n, noise),
          [columns = part.columns(Sensor::kAcc), &b] { return columns->mean(b.first, b.count); });
    }
  }
  means.finish();
}

void add_magnetometer(FactorGraph& graph, const Part& part, int sensor) {
  const VectorSeries& series = part.recording.mag[std::size_t(sensor)];
  const bool delayed = part.spec.mag_time_offset;
  const double offset = delayed ? part.spec.mag_offset_s[std::size_t(sensor)] : 0.0;
  const std::vector<NodeMean>& of_nodes = part.gathered.mag(part.index, sensor);
  const double rate = part.spec.mag_rate_hz > 0.0 ? part.spec.mag_rate_hz : series.rate_hz();
  const Key D = key::distortion_of(sensor);
  const Key dip = dip_of(part.plan.field);
  // Effects are those of the first magnetometer.
  const std::initializer_list<Sensor> mag = {Sensor::kMag}, none = {};
  const std::size_t all = part.of_all_magnetometers();
  Collector<DelayedMagnetometerFactor> lagging(graph, part, sensor == 0 && delayed ? mag : none,
                                               all);
  const bool placed = sensor == 0 && part.extended != nullptr && !part.extended->position.empty();
  if (placed && delayed) {
    throw NumericalError("a field of the place beside a lag of the magnetometer is no model");
  }
  Collector<MeanMagnetometerFactor> means(graph, part,
                                          sensor == 0 && !delayed && !placed ? mag : none, all);
  Collector<PlacedMagnetometerFactor> at_places(graph, part, placed ? mag : none, all);
  for (int i = 0; i < part.nodes(); ++i) {
    const NodeMean& b = of_nodes[std::size_t(i)];
    if (!(b.independent > 0.0) || !part.measures(i)) continue;
    if (part.spec.without_mag && part.spec.without_mag(part.id(i))) continue;
    const Key pose = R(part.id(i));
    const Key bias =
        key::mag_bias_of(sensor, part.spec.earlier_bias ? part.spec.earlier_bias(part.id(i)) : 0);
    const Noise<3> noise =
        made_of_samples(part, part.recording.mag_names[std::size_t(sensor)], i,
                        [&] { return noise_of_mean(mag_density(part.spec, sensor), rate, b); });
    const auto gain = [columns = part.columns(Sensor::kMag), &b] {
      return columns->mean(b.first, b.count);
    };
    if (delayed) {
      lagging.add(DelayedMagnetometerFactor(pose, D, bias, dip, key::mag_time_offset_of(sensor),
                                            b.mean, b.C, b.C_rate, offset, noise),
                  gain);
    } else if (placed) {
      at_places.add(PlacedMagnetometerFactor(pose, D, bias, dip, P(part.id(i)), b.mean, b.C,
                                             part.extended->position[std::size_t(i)],
                                             part.extended->by_position[std::size_t(i)], noise),
                    gain);
    } else if (b.at_node && !means.extended()) {
      reserve<MagnetometerFactor>(graph, all);
      graph.add(MagnetometerFactor(pose, D, bias, dip, b.mean, noise));
    } else {
      means.add(MeanMagnetometerFactor(pose, D, bias, dip, b.mean, b.C, noise), gain);
    }
  }
  lagging.finish();
  means.finish();
  at_places.finish();
}

void add_gyroscope(FactorGraph& graph, const Part& part) {
  const VectorSeries& samples = part.recording.gyr;
  Collector<PreintegratedGyroscopeFactor> integrated(graph, part, {Sensor::kGyr},
                                                     part.plan.t.size());
  const GatheredMotion& motion = part.gathered.motion(part.index);
  for (int i = 0; i + 1 < part.nodes(); ++i) {
    const Key pose = R(part.id(i)), next = R(part.id(i + 1));
    const long k = motion.single[std::size_t(i)];
    const double h = part.plan.t[std::size_t(i) + 1] - part.plan.t[std::size_t(i)];
    const double density = with_gap(part.spec.noise.gyr, motion.gyr_gap, std::size_t(i), h);
    if (k >= 0) {
      graph.add(made_of_samples(part, "the gyroscope", i, [&] {
        return GyroscopeFactor(pose, next, key::gyr_bias, samples.v[std::size_t(k)], h,
                               Noise<3>::isotropic(density / std::sqrt(h)));
      }));
    } else {
      const PreintegratedGyroscope& gyr = motion.turns[std::size_t(i)];
      const auto factor = made_of_samples(part, "the gyroscope", i, [&] {
        return PreintegratedGyroscopeFactor(pose, next, key::gyr_bias, gyr, density);
      });
      integrated.add(factor, [&gyr, &gathered = part.gathered, r = part.index, i] {
        return gathered.on_demand() ? gathered.turn_by_effects(r, std::size_t(i))
                                    : gyr.effect_jacobian();
      });
    }
  }
  integrated.finish();
}

void add_imu(FactorGraph& graph, const Part& part) {
  const Vector3 g_n = gravity_n(part.spec.gravity);
  const ModelSpec& spec = part.spec;
  // Nothing measures where a travelling sensor is (imu_noise()).
  const double loose_m = spec.motion == MotionModel::kTravelling ? 1.0 : 0.0;
  const std::vector<double> acc_density =
      acc_densities(part.recording.acc, part.plan.t, spec.noise.acc, spec.acc_jitter);
  Collector<PreintegratedImuFactor> plain(graph, part, {Sensor::kGyr, Sensor::kAcc},
                                          part.plan.t.size());
  Collector<ScaledImuFactor> scaled(graph, part, {Sensor::kGyr, Sensor::kAcc}, part.plan.t.size());
  for (int i = 1; i < part.nodes(); ++i) {
    const int a = part.id(i - 1), b = part.id(i);
    const GatheredMotion& motion = part.gathered.motion(part.index);
    const std::size_t interval = std::size_t(i) - 1;
    const PreintegratedImu& integrated = motion.imu[interval];
    const double h = integrated.duration_s();
    const double acc = with_gap(acc_density[std::size_t(i)], motion.acc_gap, interval, h);
    const double gyr = with_gap(spec.noise.gyr, motion.gyr_gap, interval, h);
    const auto gain = [&integrated, &gathered = part.gathered, r = part.index, interval] {
      return gathered.on_demand() ? gathered.imu_by_effects(r, interval)
                                  : integrated.effect_jacobian();
    };
    const std::string imu = "gyroscope and accelerometer";
    if (spec.gyr_matrix) {
      const auto factor = made_of_samples(part, imu, i, [&] {
        return ScaledImuFactor(R(a), V(a), P(a), R(b), V(b), P(b), key::gyr_bias, key::acc_bias,
                               key::gyr_matrix, integrated, gyr, acc, g_n, loose_m);
      });
      scaled.add(factor, gain);
    } else {
      const auto factor = made_of_samples(part, imu, i, [&] {
        return PreintegratedImuFactor(R(a), V(a), P(a), R(b), V(b), P(b), key::gyr_bias,
                                      key::acc_bias, integrated, gyr, acc, g_n, loose_m);
      });
      plain.add(factor, gain);
    }
  }
  plain.finish();
  scaled.finish();
}

// Factors for what is assumed of the motion: a bound on the position, or one on the velocity.
void add_reach(FactorGraph& graph, const Part& part) {
  const bool travels = part.spec.motion == MotionModel::kTravelling;
  const Noise<3> noise = Noise<3>::isotropic(travels ? part.spec.speed_mps : part.spec.reach_m);
  const Key own = key::lever_arm_of(part.plan.field);
  const std::vector<double>& t = part.plan.t;
  // Between two gaps a part may have a single node, and nothing tells how fast the hand was there.
  if (part.nodes() == 1 && !travels) {
    constexpr double kHandSpeed = 1.0;  // m/s
    graph.add(
        PriorFactor<Vector3>(V(part.id(0)), Vector3::Zero(), Noise<3>::isotropic(kHandSpeed)));
  }
  // Three at the least: with two, velocity and tilt of a short part are not told apart.
  const double every =
      std::min(travels ? part.spec.velocity_every_s : kReachEvery, 0.5 * (t.back() - t.front()));
  // Nothing measures where a travelling sensor begins, and nothing depends on it: any place will
  // do.
  if (travels) {
    graph.add(PriorFactor<Vector3>(P(part.id(0)), Vector3::Zero(), Noise<3>::isotropic(1.0)));
  }
  double due = t.front();
  for (int i = 0; i < part.nodes(); ++i) {
    const bool is_due = part.spec.reach_at ? part.measures(i) && part.spec.reach_at(part.id(i))
                                           : t[std::size_t(i)] >= due || i + 1 == part.nodes();
    if (!is_due) continue;
    const Key bounded = travels ? V(part.id(i)) : P(part.id(i));
    graph.add(ReachFactor(R(part.id(i)), bounded, own, Vector3::Zero(), noise));
    due = t[std::size_t(i)] + every;
  }
}

}  // namespace

std::string to_string(MotionModel motion) {
  switch (motion) {
    case MotionModel::kAuto:
      return "auto";
    case MotionModel::kRotation:
      return "rotation";
    case MotionModel::kHandHeld:
      return "hand_held";
    case MotionModel::kTravelling:
      return "travelling";
  }
  return "?";
}

Noise<9> gyr_matrix_noise() {
  Vec<double, 9> sigma = Vec<double, 9>::Constant(kGyrAxesPriorSigma);
  for (const int e : {0, 4, 8}) sigma[e] = kGyrScalePriorSigma;
  return Noise<9>::diagonal(sigma);
}

double mag_density(const ModelSpec& spec, int magnetometer) {
  return spec.mag_noise.empty() ? spec.noise.mag : spec.mag_noise[std::size_t(magnetometer)];
}

FactorGraph build_model(const std::vector<const Recording*>& recordings,
                        const std::vector<NodePlan>& plans, const ModelSpec& spec, int widened_from,
                        double widening) {
  return build_model(GatheredSamples(recordings, plans, spec), recordings, plans, spec,
                     widened_from, widening);
}

FactorGraph build_model(const GatheredSamples& gathered,
                        const std::vector<const Recording*>& recordings,
                        const std::vector<NodePlan>& plans, const ModelSpec& spec, int widened_from,
                        double widening) {
  FactorGraph graph;
  const int magnetometers = int(recordings.front()->mag.size());
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const ExtendedRecording* extended = spec.extended.empty() ? nullptr : spec.extended[i].get();
    const Recording& recording = extended != nullptr ? extended->corrected : *recordings[i];
    const Part part{recording, plans[i], gathered, int(i), spec, extended};
    if (is_moved(spec.motion)) {
      add_imu(graph, part);
      add_reach(graph, part);
    } else {
      add_accelerometer(graph, part);
      add_gyroscope(graph, part);
    }
    for (int m = 0; m < magnetometers; ++m) add_magnetometer(graph, part, m);
  }
  if (plans.front().continues) return graph;
  const std::vector<std::vector<Key>> keys = effect_keys(spec.effects);
  for (std::size_t e = 0; e < spec.effects.size(); ++e) {
    const double wider = int(e) >= widened_from ? widening : 1.0;
    const VectorXd sigma = wider * spec.effects[e]->prior_sigma(recordings.front()->duration_s());
    for (std::size_t i = 0; i < keys[e].size(); ++i) {
      graph.add(PriorFactor<double>(keys[e][i], 0.0, Noise<1>::isotropic(sigma[Eigen::Index(i)])));
    }
  }
  if (is_moved(spec.motion)) {
    for (int r = 0; r <= plans.back().field; ++r) {
      graph.add(PriorFactor<Vector3>(
          key::lever_arm_of(r), Vector3::Zero(),
          Noise<3>::isotropic(spec.motion == MotionModel::kTravelling ? kOwnVelocityPriorSigma
                                                                      : kLeverArmPriorSigma)));
    }
  }
  if (spec.gyr_matrix) {
    graph.add(PriorFactor<GyroMatrix>(key::gyr_matrix, GyroMatrix::Zero(), gyr_matrix_noise()));
  }
  if (spec.mag_time_offset) {
    for (int m = 0; m < magnetometers; ++m) {
      graph.add(PriorFactor<double>(key::mag_time_offset_of(m), 0.0,
                                    Noise<1>::isotropic(kOffsetPriorSigma)));
    }
  }
  if (spec.also) spec.also(graph);
  return graph;
}

}  // namespace magimu
