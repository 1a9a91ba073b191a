// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/stream_model.h"

#include "calibration/model/held_globals.h"
#include "calibration/motion/integrated_rotation.h"
#include "calibration/start/attitude.h"
#include "factors/delayed_magnetometer_factor.h"
#include "factors/keys.h"
#include "factors/magnetometer_factor.h"
#include "factors/preintegrated_imu_factor.h"
#include "graph/numerical_error.h"
#include "solvers/levenberg_marquardt.h"

namespace magimu {
namespace {

constexpr double kFarLess =
    1e-2;  // in our units: less information than a window has on any parameter
// s: positions are measured at three times in the first second of a part, so that velocity and tilt
// are distinguished even in a short part.
constexpr double kStart = 0.6, kReachAtStart = 0.4;

SensorParameters parameters_of(const Values& values, int magnetometers) {
  SensorParameters out;
  out.acc_bias = values.at<Vector3>(key::acc_bias);
  out.gyr_bias = values.at<Vector3>(key::gyr_bias);
  out.dip_rad = values.at<double>(key::dip);
  out.mag.clear();
  for (int m = 0; m < magnetometers; ++m) {
    out.mag.push_back(
        {values.at<Matrix3>(key::distortion_of(m)), values.at<Vector3>(key::mag_bias_of(m))});
  }
  return out;
}

bool is_field(const FactorBatch& batch) {
  return dynamic_cast<const FactorBatchOf<MagnetometerFactor>*>(&batch) != nullptr ||
         dynamic_cast<const FactorBatchOf<MeanMagnetometerFactor>*>(&batch) != nullptr ||
         dynamic_cast<const FactorBatchOf<DelayedMagnetometerFactor>*>(&batch) != nullptr;
}

// Propagates a window's first node by accelerometer and gyroscope.
void lead_on(const FactorGraph& motion, int first, Rot3 nRb, Vector3 v, Vector3 p, Values& to) {
  int k = first;
  for (const PreintegratedImuFactor& factor : motion.factors<PreintegratedImuFactor>()) {
    factor.advance(nRb, v, p);
    to.insert(R(++k), nRb);
    to.insert(V(k), v);
    to.insert(P(k), p);
  }
}
void lead_on(const IntegratedRotation& gyr, const NodePlan& plan, Rot3 nRb, Values& to) {
  for (std::size_t i = 1; i < plan.t.size(); ++i) {
    nRb = (nRb * gyr.between(plan.t[i - 1], plan.t[i])).normalized();
    to.insert(R(plan.first + int(i)), nRb);
  }
}

// Nodes of the first window of a part: from gravity and the field of all of it, then at the optimum
// of its own factors with the globals as they are, for the estimator's steps are Gauss-Newton's.
Values start_of_part(const Recording& part, const NodePlan& plan, const FactorGraph& factors,
                     const ModelSpec& spec, const Values& front) {
  const IntegratedRotation gyr(part.gyr, spec.gyr_bias);
  const double middle = 0.5 * (plan.t.front() + plan.t.back());
  const Rot3 in_the_middle =
      estimate_attitudes(part, parameters_of(front, int(part.mag.size())), gyr, {middle}).front();
  const Rot3 nRb = (in_the_middle * gyr.between(middle, plan.t.front())).normalized();
  Values nodes;
  nodes.insert(R(plan.first), nRb);
  if (is_moved(spec.motion)) {
    nodes.insert(V(plan.first), Vector3::Zero().eval());
    nodes.insert(P(plan.first), Vector3::Zero().eval());
    lead_on(factors, plan.first, nRb, Vector3::Zero(), Vector3::Zero(), nodes);
  } else {
    lead_on(gyr, plan, nRb, nodes);
  }
  FactorGraph graph;
  for (const auto& batch : factors.batches()) graph.add_batch(batch->clone());
  Values all = nodes, globals;
  for (const Values::Slot& s : front.slots()) {
    if (!is_calibration_global(s.key)) continue;
    all.insert_from(front, s.key);
    globals.insert_from(front, s.key);
  }
  hold_globals(globals, VectorXd::Constant(globals.dim(), kFarLess), graph);
  const std::optional<Result> fitted =
      attempt([&] { return LevenbergMarquardt(graph).optimize(all); });
  if (!fitted || !fitted->converged()) return nodes;
  Values out;
  for (const Values::Slot& s : nodes.slots()) out.insert_from(fitted->values, s.key);
  return out;
}

}  // namespace

bool is_calibration_global(Key key) {
  return key.symbol != R(0).symbol && key.symbol != V(0).symbol && key.symbol != P(0).symbol;
}

std::function<bool(int node)> reach_every_few_seconds(const StreamSamples& samples) {
  return [&samples, due = -1e300, is_due = std::vector<bool>()](int node) mutable {
    while (is_due.size() <= std::size_t(node)) {
      const double t = samples.node_t()[is_due.size()];
      const double since = samples.since_begin_of_part(int(is_due.size()));
      is_due.push_back(since == 0.0 || t >= due);
      if (is_due.back()) due = t + (since < kStart ? kReachAtStart : kReachEvery);
    }
    return bool(is_due[std::size_t(node)]);
  };
}

WindowFactors window_factors(const StreamSamples& samples, const StreamWindow& window,
                             const ModelSpec& spec, const Values* front,
                             std::span<const double> ends) {
  const Recording part = samples.part(window, ends);
  const NodePlan plan = samples.plan(window);
  const FactorGraph all = build_model({&part}, {plan}, spec);
  WindowFactors out;
  for (const auto& batch : all.batches()) {
    (is_field(*batch) ? out.field : out.motion).add_batch(batch->clone());
  }
  if (front == nullptr) return out;
  if (window.begins) {
    out.values = start_of_part(part, plan, all, spec, *front);
    return out;
  }
  const Rot3 nRb = front->at<Rot3>(R(window.first));
  if (is_moved(spec.motion)) {
    lead_on(all, window.first, nRb, front->at<Vector3>(V(window.first)),
            front->at<Vector3>(P(window.first)), out.values);
  } else {
    lead_on(IntegratedRotation(part.gyr, spec.gyr_bias), plan, nRb, out.values);
  }
  return out;
}

void take_over(const StreamWindow& window, const ModelSpec& spec, const Values& known,
               WindowFactors& w) {
  if (window.first == 0) {
    for (const Values::Slot& s : known.slots()) {
      if (is_calibration_global(s.key)) w.values.insert_from(known, s.key);
    }
  }
  for (int k = window.begins ? window.first : window.first + 1; k <= window.last; ++k) {
    w.values.insert_from(known, R(k));
    if (!is_moved(spec.motion)) continue;
    w.values.insert_from(known, V(k));
    w.values.insert_from(known, P(k));
  }
}

}  // namespace magimu
