// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/rotation_model.h"

#include <algorithm>
#include <cmath>

#include "factors/accelerometer_factor.h"
#include "factors/gyroscope_factor.h"
#include "factors/magnetometer_factor.h"
#include "factors/preintegrated_gyroscope_factor.h"

namespace magimu {
namespace {

constexpr double kSameTime = 1e-9;  // s

// The samples of one series that belong to a node, as their mean.
struct Block {
  int count = 0;
  Vector3 mean = Vector3::Zero();
  Matrix3 C = Matrix3::Zero();  // mean rotation from the node's frame to the samples'
  bool at_node = false;         // one sample, at the node's very time
};

// Hands out blocks node after node; every sample falls to the node nearest in time.
class BlockWalker {
 public:
  BlockWalker(const VectorSeries& series, const IntegratedRotation& gyr, const NodePlan& plan)
      : series_(series), gyr_(gyr), plan_(plan) {
    const double half_first = plan.t.size() > 1 ? 0.5 * (plan.t[1] - plan.t[0]) : 0.5;
    while (next_ < series_.size() && series_.t[next_] < plan.t.front() - half_first) ++next_;
  }

  Block next(std::size_t node) {
    const std::vector<double>& t = plan_.t;
    const double end = node + 1 < t.size() ? 0.5 * (t[node] + t[node + 1])
                                           : t[node] + 0.5 * (t[node] - t[node - 1]);
    Block block;
    const std::size_t first = next_;
    while (next_ < series_.size() && series_.t[next_] < end) ++next_;
    block.count = int(next_ - first);
    block.at_node = block.count == 1 && std::abs(series_.t[first] - t[node]) < kSameTime;
    if (block.at_node) {
      block.mean = series_.v[first];
      return block;
    }
    if (block.count == 0) return block;
    const Rot3 to_node = gyr_.at(t[node]).inverse();
    for (std::size_t k = first; k < next_; ++k) {
      block.mean += series_.v[k];
      block.C += (to_node * gyr_.at(series_.t[k])).matrix().transpose();
    }
    block.mean /= double(block.count);
    block.C /= double(block.count);
    return block;
  }

 private:
  const VectorSeries& series_;
  const IntegratedRotation& gyr_;
  const NodePlan& plan_;
  std::size_t next_ = 0;
};

Noise<3> block_noise(double density, double rate_hz, int count) {
  return Noise<3>::isotropic(density * std::sqrt(rate_hz / count));
}

void add_accelerometer(FactorGraph& graph, const Recording& r, const IntegratedRotation& gyr,
                       const NodePlan& plan, double density, double gravity) {
  BlockWalker blocks(r.acc, gyr, plan);
  const double rate = r.acc.rate_hz();
  const Vector3 g_n = gravity_n(gravity);
  for (std::size_t i = 0; i < plan.t.size(); ++i) {
    const Block b = blocks.next(i);
    if (b.count == 0) continue;
    const Key pose = R(plan.first + int(i));
    const Noise<3> noise = block_noise(density, rate, b.count);
    if (b.at_node) {
      graph.add(AccelerometerFactor(pose, key::acc_bias, b.mean, g_n, noise));
    } else {
      graph.add(MeanAccelerometerFactor(pose, key::acc_bias, b.mean, b.C, g_n, noise));
    }
  }
}

void add_magnetometer(FactorGraph& graph, const Recording& r, int sensor,
                      const IntegratedRotation& gyr, const NodePlan& plan, Key dip,
                      double density) {
  const VectorSeries& series = r.mag[std::size_t(sensor)];
  BlockWalker blocks(series, gyr, plan);
  const double rate = series.rate_hz();
  const Key D = key::distortion_of(sensor), bias = key::mag_bias_of(sensor);
  for (std::size_t i = 0; i < plan.t.size(); ++i) {
    const Block b = blocks.next(i);
    if (b.count == 0) continue;
    const Key pose = R(plan.first + int(i));
    const Noise<3> noise = block_noise(density, rate, b.count);
    if (b.at_node) {
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

void add_gyroscope(FactorGraph& graph, const Recording& r, const IntegratedRotation& gyr,
                   const NodePlan& plan, double density) {
  for (std::size_t i = 0; i + 1 < plan.t.size(); ++i) {
    const double a = plan.t[i], b = plan.t[i + 1];
    const Key pose = R(plan.first + int(i)), next = R(plan.first + int(i) + 1);
    if (const long k = single_sample(r.gyr, a, b); k >= 0) {
      graph.add(GyroscopeFactor(pose, next, key::gyr_bias, r.gyr.v[std::size_t(k)], b - a,
                                Noise<3>::isotropic(density / std::sqrt(b - a))));
    } else {
      graph.add(PreintegratedGyroscopeFactor(pose, next, key::gyr_bias, gyr.preintegrate(a, b),
                                             density));
    }
  }
}

}  // namespace

std::vector<NodePlan> plan_nodes(const std::vector<const Recording*>& recordings, int every) {
  std::vector<NodePlan> plans;
  int first = 0;
  for (const Recording* r : recordings) {
    NodePlan plan;
    plan.first = first;
    const VectorSeries& mag = r->mag.front();
    for (std::size_t k = 0; k < mag.size(); k += std::size_t(every)) {
      if (mag.t[k] >= r->gyr.t.front() - kSameTime && mag.t[k] <= r->gyr.t.back() + kSameTime) {
        plan.t.push_back(mag.t[k]);
      }
    }
    first += int(plan.t.size());
    plans.push_back(std::move(plan));
  }
  return plans;
}

RotationModel build_rotation_model(const std::vector<const Recording*>& recordings,
                                   const std::vector<NodePlan>& plans, const Vector3& gyr_bias,
                                   const NoiseDensities& noise, double gravity) {
  RotationModel model;
  model.integrated_at = gyr_bias;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const Recording& r = *recordings[i];
    const IntegratedRotation gyr(r.gyr, gyr_bias);
    add_accelerometer(model.graph, r, gyr, plans[i], noise.acc, gravity);
    for (int m = 0; m < int(r.mag.size()); ++m) {
      add_magnetometer(model.graph, r, m, gyr, plans[i], dip_of(int(i)), noise.mag);
    }
    add_gyroscope(model.graph, r, gyr, plans[i], noise.gyr);
  }
  return model;
}

}  // namespace magimu
