// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/model.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "calibration/block_means.h"
#include "factors/accelerometer_factor.h"
#include "factors/delayed_magnetometer_factor.h"
#include "factors/gyroscope_factor.h"
#include "factors/magnetometer_factor.h"
#include "factors/preintegrated_gyroscope_factor.h"
#include "factors/preintegrated_imu_factor.h"
#include "factors/prior_factor.h"

namespace magimu {
namespace {

constexpr double kSameTime = 1e-9;             // s
constexpr double kReachEvery = 3.0;            // s between weak measurements of position
constexpr double kGyrMatrixPriorSigma = 0.01;  // of ordinary parts
constexpr double kOffsetPriorSigma = 0.1;      // s: longer lags are another kind of fault

Noise<3> block_noise(double density, double rate_hz, int count) {
  return Noise<3>::isotropic(density * std::sqrt(rate_hz / count));
}

// One recording being put into the graph.
struct Part {
  const Recording& recording;
  const NodePlan& plan;
  const IntegratedRotation& gyr;
  int index;  // of the recording
  const ModelSpec& spec;

  int nodes() const { return int(plan.t.size()); }
  int id(int i) const { return plan.first + i; }
};

void add_accelerometer(FactorGraph& graph, const Part& part) {
  BlockMeans blocks(part.recording.acc, part.gyr, part.plan);
  const double rate = part.recording.acc.rate_hz();
  const Vector3 g_n = gravity_n(part.spec.gravity);
  for (int i = 0; i < part.nodes(); ++i) {
    const Block b = blocks.next();
    if (b.count == 0) continue;
    const Key pose = R(part.id(i));
    const Noise<3> noise = block_noise(part.spec.noise.acc, rate, b.count);
    if (b.at_node) {
      graph.add(AccelerometerFactor(pose, key::acc_bias, b.mean, g_n, noise));
    } else {
      graph.add(MeanAccelerometerFactor(pose, key::acc_bias, b.mean, b.C, g_n, noise));
    }
  }
}

void add_magnetometer(FactorGraph& graph, const Part& part, int sensor) {
  const VectorSeries& series = part.recording.mag[std::size_t(sensor)];
  const bool delayed = part.spec.mag_time_offset;
  const double offset = delayed ? part.spec.mag_offset_s[std::size_t(sensor)] : 0.0;
  BlockMeans blocks(series, part.gyr, part.plan, offset);
  const double rate = series.rate_hz();
  const Key D = key::distortion_of(sensor), bias = key::mag_bias_of(sensor);
  const Key dip = dip_of(part.index);
  for (int i = 0; i < part.nodes(); ++i) {
    const Block b = blocks.next();
    if (b.count == 0 || (part.spec.without_mag && part.spec.without_mag(part.id(i)))) continue;
    const Key pose = R(part.id(i));
    const Noise<3> noise = block_noise(part.spec.noise.mag, rate, b.count);
    if (delayed) {
      graph.add(DelayedMagnetometerFactor(pose, D, bias, dip, key::mag_time_offset_of(sensor),
                                          b.mean, b.C, b.C_rate, offset, noise));
    } else if (b.at_node) {
      graph.add(MagnetometerFactor(pose, D, bias, dip, b.mean, noise));
    } else {
      graph.add(MeanMagnetometerFactor(pose, D, bias, dip, b.mean, b.C, noise));
    }
  }
}

// One gyroscope sample that spans exactly the two nodes, or -1.
long single_sample(const VectorSeries& gyr, double a, double b) {
  const auto it = std::lower_bound(gyr.t.begin(), gyr.t.end(), a - kSameTime);
  const long k = it - gyr.t.begin();
  if (k + 1 >= long(gyr.size())) return -1;
  const bool spans = std::abs(gyr.t[std::size_t(k)] - a) < kSameTime &&
                     std::abs(gyr.t[std::size_t(k) + 1] - b) < kSameTime;
  return spans ? k : -1;
}

void add_gyroscope(FactorGraph& graph, const Part& part) {
  const double density = part.spec.noise.gyr;
  const VectorSeries& samples = part.recording.gyr;
  for (int i = 0; i + 1 < part.nodes(); ++i) {
    const double a = part.plan.t[std::size_t(i)], b = part.plan.t[std::size_t(i) + 1];
    const Key pose = R(part.id(i)), next = R(part.id(i + 1));
    if (const long k = single_sample(samples, a, b); k >= 0) {
      graph.add(GyroscopeFactor(pose, next, key::gyr_bias, samples.v[std::size_t(k)], b - a,
                                Noise<3>::isotropic(density / std::sqrt(b - a))));
    } else {
      graph.add(PreintegratedGyroscopeFactor(pose, next, key::gyr_bias, part.gyr.preintegrate(a, b),
                                             density));
    }
  }
}

void add_imu(FactorGraph& graph, const Part& part) {
  const Vector3 g_n = gravity_n(part.spec.gravity);
  const ModelSpec& spec = part.spec;
  const std::vector<double>& t = part.plan.t;
  std::vector<std::optional<PreintegratedImu>> imu(t.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(1, t.size(), 64), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      imu[i] = part.gyr.preintegrate(t[i - 1], t[i], part.recording.acc, spec.acc_bias,
                                     spec.noise.gyr, spec.noise.acc, spec.gyr_matrix);
    }
  });
  for (int i = 1; i < part.nodes(); ++i) {
    const int a = part.id(i - 1), b = part.id(i);
    const PreintegratedImu& integrated = *imu[std::size_t(i)];
    if (spec.gyr_matrix) {
      graph.add(ScaledImuFactor(R(a), V(a), P(a), R(b), V(b), P(b), key::gyr_bias, key::acc_bias,
                                key::gyr_matrix, integrated, g_n));
    } else {
      graph.add(PreintegratedImuFactor(R(a), V(a), P(a), R(b), V(b), P(b), key::gyr_bias,
                                       key::acc_bias, integrated, g_n));
    }
  }
}

void add_reach(FactorGraph& graph, const Part& part) {
  const Noise<3> noise = Noise<3>::isotropic(part.spec.reach_m);
  double due = part.plan.t.front();
  for (int i = 0; i < part.nodes(); ++i) {
    if (part.plan.t[std::size_t(i)] < due && i + 1 < part.nodes()) continue;
    graph.add(PriorFactor<Vector3>(P(part.id(i)), Vector3::Zero(), noise));
    due = part.plan.t[std::size_t(i)] + kReachEvery;
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
  }
  return "?";
}

FactorGraph build_model(const std::vector<const Recording*>& recordings,
                        const std::vector<NodePlan>& plans, const ModelSpec& spec) {
  FactorGraph graph;
  const int magnetometers = int(recordings.front()->mag.size());
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const IntegratedRotation gyr(recordings[i]->gyr, spec.gyr_bias, spec.gyr_matrix_value);
    const Part part{*recordings[i], plans[i], gyr, int(i), spec};
    if (spec.motion == MotionModel::kHandHeld) {
      add_imu(graph, part);
      add_reach(graph, part);
    } else {
      add_accelerometer(graph, part);
      add_gyroscope(graph, part);
    }
    for (int m = 0; m < magnetometers; ++m) add_magnetometer(graph, part, m);
  }
  if (spec.gyr_matrix) {
    graph.add(PriorFactor<LowerTriangle>(key::gyr_matrix, LowerTriangle::Zero(),
                                         Noise<6>::isotropic(kGyrMatrixPriorSigma)));
  }
  if (spec.mag_time_offset) {
    for (int m = 0; m < magnetometers; ++m) {
      graph.add(PriorFactor<double>(key::mag_time_offset_of(m), 0.0,
                                    Noise<1>::isotropic(kOffsetPriorSigma)));
    }
  }
  return graph;
}

}  // namespace magimu
