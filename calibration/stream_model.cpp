// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/stream_model.h"

#include "calibration/integrated_rotation.h"
#include "factors/delayed_magnetometer_factor.h"
#include "factors/keys.h"
#include "factors/magnetometer_factor.h"
#include "factors/preintegrated_imu_factor.h"

namespace magimu {
namespace {

bool is_field(const FactorBatch& batch) {
  return dynamic_cast<const FactorBatchOf<MagnetometerFactor>*>(&batch) != nullptr ||
         dynamic_cast<const FactorBatchOf<MeanMagnetometerFactor>*>(&batch) != nullptr ||
         dynamic_cast<const FactorBatchOf<DelayedMagnetometerFactor>*>(&batch) != nullptr;
}

}  // namespace

bool is_calibration_global(Key key) {
  return key.symbol != R(0).symbol && key.symbol != V(0).symbol && key.symbol != P(0).symbol;
}

std::function<bool(int node)> reach_every_few_seconds(const StreamSamples& samples) {
  return [&samples, due = -1e300, is_due = std::vector<bool>()](int node) mutable {
    while (is_due.size() <= std::size_t(node)) {
      const double t = samples.node_t()[is_due.size()];
      is_due.push_back(t >= due);
      if (is_due.back()) due = t + kReachEvery;
    }
    return bool(is_due[std::size_t(node)]);
  };
}

WindowFactors window_factors(const StreamSamples& samples, const StreamWindow& window,
                             const ModelSpec& spec, const Values* front) {
  const Recording part = samples.part(window);
  const NodePlan plan = samples.plan(window);
  const FactorGraph all = build_model({&part}, {plan}, spec);
  WindowFactors out;
  for (const auto& batch : all.batches()) {
    (is_field(*batch) ? out.field : out.motion).add_batch(batch->clone());
  }
  if (front == nullptr) return out;
  Rot3 nRb = front->at<Rot3>(R(window.first));
  if (spec.motion == MotionModel::kHandHeld) {
    Vector3 v = front->at<Vector3>(V(window.first)), p = front->at<Vector3>(P(window.first));
    int k = window.first;
    for (const PreintegratedImuFactor& factor : all.factors<PreintegratedImuFactor>()) {
      factor.advance(nRb, v, p);
      out.values.insert(R(++k), nRb);
      out.values.insert(V(k), v);
      out.values.insert(P(k), p);
    }
    return out;
  }
  const IntegratedRotation gyr(part.gyr, spec.gyr_bias);
  for (std::size_t i = 1; i < plan.t.size(); ++i) {
    nRb = (nRb * gyr.between(plan.t[i - 1], plan.t[i])).normalized();
    out.values.insert(R(plan.first + int(i)), nRb);
  }
  return out;
}

void take_over(const StreamWindow& window, const ModelSpec& spec, const Values& known,
               WindowFactors& w) {
  const bool starts = window.first == 0;
  if (starts) {
    for (const Values::Slot& s : known.slots()) {
      if (is_calibration_global(s.key)) w.values.insert_from(known, s.key);
    }
  }
  for (int k = starts ? 0 : window.first + 1; k <= window.last; ++k) {
    w.values.insert_from(known, R(k));
    if (spec.motion != MotionModel::kHandHeld) continue;
    w.values.insert_from(known, V(k));
    w.values.insert_from(known, P(k));
  }
}

}  // namespace magimu
