// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/model/extension.h"

#include <algorithm>
#include <memory>

#include "calibration/model/sensed_motion.h"
#include "calibration/motion/sample_times.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

constexpr int kRounds = 12;
constexpr double kSettled = 1e-10;  // rad/s or m/s^2

struct ActiveTerm {
  std::shared_ptr<const Effect> effect;
  VectorXd theta;
  int first;  // its first column among those of its channel
};

// Of a sensor that only turns the force is that of its attitude.
bool need_attitude(const std::vector<ActiveTerm>& active, bool moving) {
  return !moving || !std::ranges::all_of(active, [](const ActiveTerm& a) {
    return a.effect->description().without_attitude;
  });
}
SampleState state_for(const SensedMotion& motion, Sensor channel, std::size_t sample,
                      bool attitude) {
  return attitude ? motion.state(channel, sample) : motion.state_without_attitude(channel, sample);
}

// Is a part of the state this sensor's own reading? The force, where the accelerometer is moved.
// (The rate is that of the estimated attitudes.)
bool reads_state(Sensor channel, bool moving) { return channel == Sensor::kAcc && moving; }
Vector3* own_part(SampleState& state, Sensor channel, bool moving) {
  return reads_state(channel, moving) ? &state.f : nullptr;
}

// What is there beside a delay is there at the delayed time.
double delay_of(const std::vector<ActiveTerm>& active) {
  double sum = 0.0;
  for (const ActiveTerm& a : active) sum += a.effect->delay(a.theta);
  return sum;
}

// Of one sample. Terms may depend on what they correct (a scale error on the rate), so what has
// been corrected takes its place in the state until it no longer changes: each round is closer by a
// scale error's size.
Vector3 sum_of_terms(const std::vector<ActiveTerm>& active, const Vector3& raw,
                     const Vector3& corrected, SampleState& state, Vector3* own) {
  const Vector3 less_bias = own == nullptr ? Vector3::Zero() : Vector3(*own - corrected);
  Vector3 sum = Vector3::Zero();
  for (int round = 0; round < kRounds; ++round) {
    sum.setZero();
    for (const ActiveTerm& a : active) {
      if (!a.theta.isZero(0.0)) sum += a.effect->term(state, a.theta);
    }
    if (own == nullptr) break;
    const Vector3 now = raw - sum + less_bias;
    const bool settled = (now - *own).squaredNorm() < kSettled * kSettled;
    *own = now;
    if (settled) break;
  }
  return sum;
}

// raw less the effects' terms.
void correct(const SensedMotion& motion, Sensor channel, bool moving,
             const std::vector<ActiveTerm>& active, const VectorSeries& raw,
             VectorSeries& corrected) {
  const double delay_s = delay_of(active);
  const bool attitude = need_attitude(active, moving);
  parallel::for_each(raw.size(), 512, [&](std::size_t k) {
    SampleState state = state_for(motion, channel, k, attitude);
    state.delay_s += delay_s;
    const Vector3 sum =
        sum_of_terms(active, raw.v[k], corrected.v[k], state, own_part(state, channel, moving));
    corrected.v[k] = raw.v[k] - sum;
  });
}

// A motion and what it refers to.
struct KeptMotion {
  KeptMotion(const Recording& of, const NodePlan& nodes, const ModelSpec& spec,
             const Values& values, bool attitudes)
      : recording(of), plan(nodes), sensed(recording, plan, spec, values, attitudes) {}
  const Recording recording;
  const NodePlan plan;
  const SensedMotion sensed;
};

// moved: by how much the last correction has moved readings that are part of the state, sample by
// sample; the state moves with them. Empty: not at all.
EffectColumns columns_of(const std::shared_ptr<const KeptMotion>& motion, Sensor channel,
                         bool moving, const std::vector<ActiveTerm>& active,
                         std::vector<Vector3> moved) {
  EffectColumns out;
  for (const ActiveTerm& a : active) out.parameters += int(a.theta.size());
  out.write = [=, delay_s = delay_of(active), attitude = need_attitude(active, moving),
               moved = std::move(moved)](std::size_t k, EffectColumns::Columns& columns) {
    SampleState state = state_for(motion->sensed, channel, k, attitude);
    state.delay_s += delay_s;
    Vector3* const own = own_part(state, channel, moving);
    if (!moved.empty()) *own += moved[k];
    for (const ActiveTerm& a : active) {
      a.effect->jacobian(state, a.theta, columns.middleCols(a.first, a.theta.size()));
    }
  };
  return out;
}

// Of the terms on the magnetometer, at the sample of each node.
void add_positions(const SensedMotion& motion, const Recording& recording, const NodePlan& plan,
                   const Values& values, const std::vector<ActiveTerm>& active,
                   ExtendedRecording& out) {
  for (std::size_t i = 0; i < plan.t.size(); ++i) {
    const std::size_t until = count_until(recording.mag.front().t, plan.t[i]);
    const SampleState state = motion.state(Sensor::kMag, until > 0 ? until - 1 : 0);
    Matrix3 sum = Matrix3::Zero();
    for (const ActiveTerm& a : active) {
      if (a.effect->description().of_position) sum += a.effect->by_position(state, a.theta);
    }
    out.position.push_back(values.at<Vector3>(P(plan.first + int(i))));
    out.by_position.push_back(sum);
  }
}

}  // namespace

std::vector<std::vector<Key>> effect_keys(
    const std::vector<std::shared_ptr<const Effect>>& effects) {
  std::vector<std::vector<Key>> out;
  int next = 0;
  for (const auto& effect : effects) {
    out.emplace_back();
    for (int i = 0; i < effect->size(); ++i) out.back().push_back(key::effect(next++));
  }
  return out;
}

VectorXd effect_parameters(const Values& values, const std::vector<Key>& keys) {
  VectorXd theta = VectorXd::Zero(Eigen::Index(keys.size()));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (values.contains(keys[i])) theta[Eigen::Index(i)] = values.at<double>(keys[i]);
  }
  return theta;
}

ExtendedRecording extend(const Recording& recording, const NodePlan& plan, const ModelSpec& spec,
                         const Values& values) {
  ExtendedRecording out;
  out.corrected = recording;
  std::array<std::vector<ActiveTerm>, 3> active;
  const std::vector<std::vector<Key>> keys = effect_keys(spec.effects);
  for (std::size_t e = 0; e < spec.effects.size(); ++e) {
    const auto c = std::size_t(spec.effects[e]->channel());
    active[c].push_back(
        {spec.effects[e], effect_parameters(values, keys[e]), int(out.keys[c].size())});
    out.keys[c].insert(out.keys[c].end(), keys[e].begin(), keys[e].end());
  }
  // Without a parameter that differs from zero nothing is corrected, and one pass is enough.
  const bool at_zero = std::ranges::all_of(active, [](const auto& terms) {
    return std::ranges::all_of(terms, [](const ActiveTerm& a) { return a.theta.isZero(0.0); });
  });
  const bool moving = is_moved(spec.motion);
  const bool attitudes = std::ranges::any_of(
      active, [&](const auto& terms) { return !terms.empty() && need_attitude(terms, moving); });
  std::shared_ptr<const KeptMotion> motion;
  // The gyroscope's terms depend on the force, too, and the accelerometer's on the rate: both a
  // second time with what the first has corrected. Then the magnetometer's.
  constexpr std::pair<Sensor, bool> kPasses[] = {{Sensor::kGyr, false},
                                                 {Sensor::kAcc, false},
                                                 {Sensor::kGyr, true},
                                                 {Sensor::kAcc, true},
                                                 {Sensor::kMag, true}};
  for (const auto& [channel, last] : kPasses) {
    const auto c = std::size_t(channel);
    if (active[c].empty() || (at_zero && !last)) continue;
    if (!motion || !at_zero) {
      motion = std::make_shared<const KeptMotion>(out.corrected, plan, spec, values, attitudes);
    }
    std::vector<Vector3> moved;
    if (!at_zero) {
      VectorSeries& corrected = series_of(out.corrected, channel);
      if (reads_state(channel, moving)) moved = corrected.v;
      correct(motion->sensed, channel, moving, active[c], series_of(recording, channel), corrected);
      for (std::size_t k = 0; k < moved.size(); ++k) moved[k] = corrected.v[k] - moved[k];
    }
    if (last) out.columns[c] = columns_of(motion, channel, moving, active[c], std::move(moved));
  }
  for (std::size_t c = 0; c < 3; ++c) out.theta[c] = effect_parameters(values, out.keys[c]);
  out.acc_bias = values.at<Vector3>(key::acc_bias);
  const bool of_position =
      std::ranges::any_of(spec.effects, [](const auto& e) { return e->description().of_position; });
  if (of_position && moving && !recording.pos) {
    const auto& mag = active[std::size_t(Sensor::kMag)];
    add_positions(motion->sensed, recording, plan, values, mag, out);
  }
  return out;
}

}  // namespace magimu
