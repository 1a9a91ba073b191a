// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/model/gathered.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calibration/model/extension.h"
#include "calibration/motion/bridged_gaps.h"
#include "calibration/motion/coarse_rounding.h"
#include "calibration/motion/sample_times.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

// One recording, as it is gathered.
struct Source {
  const Recording& recording;  // corrected by effects
  const Recording& given;
  const NodePlan& plan;
  const IntegratedRotation& gyr;
  const ModelSpec& spec;
  const ExtendedRecording* extended;  // null without effects
  bool with_jacobians;                // keep those of the effects

  const EffectColumns* columns(Sensor channel) const {
    const auto c = std::size_t(channel);
    return extended == nullptr || extended->keys[c].empty() ? nullptr : &extended->columns[c];
  }
};

// Effects whose parameters are zero leave a sensor's readings as they are.
bool corrects(const ModelSpec& spec, Sensor channel) {
  return !std::ranges::all_of(spec.extended, [&](const auto& extended) {
    return extended->theta[std::size_t(channel)].isZero(0.0);
  });
}
bool same_readings(const ModelSpec& a, const ModelSpec& b, Sensor channel) {
  return a.extended == b.extended || (!corrects(a, channel) && !corrects(b, channel));
}
bool integrates_columns(const ModelSpec& spec) {
  return std::ranges::any_of(spec.extended, [](const auto& extended) {
    return !extended->keys[std::size_t(Sensor::kGyr)].empty() ||
           !extended->keys[std::size_t(Sensor::kAcc)].empty();
  });
}
bool same_attitudes(const ModelSpec& a, const ModelSpec& b) {
  return a.gyr_bias == b.gyr_bias && a.gyr_matrix_value == b.gyr_matrix_value &&
         same_readings(a, b, Sensor::kGyr);
}
std::vector<double> mag_offsets(const ModelSpec& spec) {
  const std::vector<double>& own = spec.mag_offset_s;
  return spec.mag_time_offset ? own : std::vector<double>(own.size(), 0.0);
}
bool same_mag(const ModelSpec& a, const ModelSpec& b) {
  return same_attitudes(a, b) && same_readings(a, b, Sensor::kMag) &&
         mag_offsets(a) == mag_offsets(b);
}
// jacobians: whether the effects' are kept with the motion.
bool same_motion(const ModelSpec& a, const ModelSpec& b, bool jacobians) {
  if (a.motion != b.motion || !same_attitudes(a, b) || !same_readings(a, b, Sensor::kAcc)) {
    return false;
  }
  // Where the sensor only turns, an interval of one gyroscope sample is integrated beside effects
  // and not without them.
  const bool needed = jacobians || !is_moved(a.motion);
  if (needed && a.extended != b.extended && (integrates_columns(a) || integrates_columns(b))) {
    return false;
  }
  return !is_moved(a.motion) || (a.acc_bias == b.acc_bias && a.gyr_matrix == b.gyr_matrix);
}

// One gyroscope sample that spans exactly the two nodes, or -1.
long single_sample(const VectorSeries& gyr, double a, double b) {
  const std::size_t k = sample_until(gyr.t, a + kSameTime);
  if (k + 1 >= gyr.size()) return -1;
  const bool spans = std::abs(gyr.t[k] - a) < kSameTime && std::abs(gyr.t[k + 1] - b) < kSameTime;
  return spans ? long(k) : -1;
}

// body(i) for every interval between node i and the next, in parallel.
template <class Body>
void for_each_interval(const NodePlan& plan, const Body& body) {
  const std::size_t n = plan.t.empty() ? 0 : plan.t.size() - 1;
  parallel::for_each(n, 64, body);
}

void gather_turns(const Source& s, GatheredMotion& out) {
  const std::vector<double>& t = s.plan.t;
  const EffectColumns* const effects = s.columns(Sensor::kGyr);
  out.single.assign(t.size() - 1, -1);
  if (effects == nullptr) {
    for_each_interval(s.plan, [&](std::size_t i) {
      out.single[i] = single_sample(s.recording.gyr, t[i], t[i + 1]);
    });
  }
  const auto is_single = [](long k) { return k >= 0; };
  if (std::ranges::all_of(out.single, is_single)) return;
  out.turns.assign(out.single.size(), PreintegratedGyroscope(s.spec.gyr_bias));
  for_each_interval(s.plan, [&](std::size_t i) {
    const EffectColumns* const kept = s.with_jacobians ? effects : nullptr;
    if (out.single[i] < 0) out.turns[i] = s.gyr.preintegrate(t[i], t[i + 1], kept);
  });
}

// Columns of both sensors or of none.
struct ImuColumns {
  const EffectColumns *gyr = nullptr, *acc = nullptr;
};
ImuColumns imu_columns(const ExtendedRecording* extended) {
  if (extended == nullptr) return {};
  const auto g = std::size_t(Sensor::kGyr), a = std::size_t(Sensor::kAcc);
  if (extended->keys[g].empty() && extended->keys[a].empty()) return {};
  return {&extended->columns[g], &extended->columns[a]};
}

void gather_imu(const Source& s, GatheredMotion& out) {
  const std::vector<double>& t = s.plan.t;
  const ModelSpec& spec = s.spec;
  const ImuColumns of = s.with_jacobians ? imu_columns(s.extended) : ImuColumns{};
  out.imu.assign(t.size() - 1, PreintegratedImu(spec.gyr_bias, spec.acc_bias));
  for_each_interval(s.plan, [&](std::size_t i) {
    out.imu[i] = s.gyr.preintegrate(t[i], t[i + 1], s.recording.acc, spec.acc_bias, spec.gyr_matrix,
                                    of.gyr, of.acc);
  });
}

GatheredMotion gather_motion(const Source& s) {
  GatheredMotion out;
  out.gyr_gap = gap_variances(s.recording.gyr, s.plan.t);
  add_rounding(s.given.gyr, s.plan.t, out.gyr_gap);
  if (is_moved(s.spec.motion)) {
    gather_imu(s, out);
    out.acc_gap = gap_variances(s.recording.acc, s.plan.t);
    add_rounding(s.given.acc, s.plan.t, out.acc_gap);
  } else {
    out.acc = node_means(s.recording.acc, s.gyr, s.plan);
    out.acc_rounding = rounding_of_means(s.given.acc, out.acc);
    gather_turns(s, out);
  }
  return out;
}

std::vector<std::vector<NodeMean>> gather_mag(const Source& s) {
  std::vector<std::vector<NodeMean>> out;
  for (std::size_t m = 0; m < s.recording.mag.size(); ++m) {
    const double offset = s.spec.mag_time_offset ? s.spec.mag_offset_s[m] : 0.0;
    out.push_back(node_means(s.recording.mag[m], s.gyr, s.plan, offset));
    if (m >= s.plan.independent.size()) continue;
    for (std::size_t node = 0; node < out.back().size(); ++node) {
      out.back()[node].independent *= s.plan.independent[m][node];
    }
  }
  return out;
}

}  // namespace

GatheredSamples::GatheredSamples(const std::vector<const Recording*>& recordings,
                                 const std::vector<NodePlan>& plans, const ModelSpec& spec,
                                 const GatheredSamples* before, EffectJacobians jacobians)
    : spec_(spec), on_demand_(jacobians == EffectJacobians::kOnDemand && !spec.extended.empty()) {
  const bool integrals = on_demand_ && integrates_columns(spec);
  if (before != nullptr && same_motion(before->spec_, spec, !on_demand_)) motion_ = before->motion_;
  if (before != nullptr && same_mag(before->spec_, spec)) mag_ = before->mag_;
  if (motion_ && mag_ && !integrals) return;
  std::vector<GatheredMotion> motion;
  std::vector<std::vector<std::vector<NodeMean>>> mag;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const ExtendedRecording* extended = spec.extended.empty() ? nullptr : spec.extended[i].get();
    const Recording& recording = extended != nullptr ? extended->corrected : *recordings[i];
    std::optional<IntegratedRotation> own;
    if (integrals) {
      integrals_.push_back(std::make_unique<Integrals>(recording, plans[i], spec, *extended));
    } else {
      own.emplace(recording.gyr, spec.gyr_bias, spec.gyr_matrix_value);
    }
    const Source source{
        recording, *recordings[i], plans[i],   integrals ? integrals_.back()->gyr : *own,
        spec,      extended,       !on_demand_};
    if (!motion_) motion.push_back(gather_motion(source));
    if (!mag_) mag.push_back(gather_mag(source));
  }
  if (!motion_) motion_ = std::make_shared<const std::vector<GatheredMotion>>(std::move(motion));
  if (!mag_) {
    mag_ = std::make_shared<const std::vector<std::vector<std::vector<NodeMean>>>>(std::move(mag));
  }
}

Eigen::Matrix<double, 3, Eigen::Dynamic> GatheredSamples::turn_by_effects(int recording,
                                                                          std::size_t node) const {
  const Integrals& own = *integrals_[std::size_t(recording)];
  const std::vector<double>& t = own.plan.t;
  return own.gyr
      .preintegrate(t[node], t[node + 1], &own.extended.columns[std::size_t(Sensor::kGyr)])
      .effect_jacobian();
}

Eigen::Matrix<double, 9, Eigen::Dynamic> GatheredSamples::imu_by_effects(int recording,
                                                                         std::size_t node) const {
  const Integrals& own = *integrals_[std::size_t(recording)];
  const std::vector<double>& t = own.plan.t;
  const auto [of_gyr, of_acc] = imu_columns(&own.extended);
  return own.gyr
      .preintegrate(t[node], t[node + 1], own.recording.acc, spec_.acc_bias, spec_.gyr_matrix,
                    of_gyr, of_acc)
      .effect_jacobian();
}

}  // namespace magimu
