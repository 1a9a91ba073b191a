// SPDX-License-Identifier: BSD-3-Clause
// What a model takes from the samples of recordings: their means about the nodes, and what they
// integrate to between them. Noise plays no part in that, so that a fit repeated with other
// densities need not do it again.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "calibration/model/model.h"
#include "calibration/motion/block_means.h"

namespace magimu {

// Of one recording.
struct GatheredMotion {
  // The sensor only turns: the accelerometer about the nodes, and of each interval between them the
  // one gyroscope sample that spans it, or -1; what those of all others integrate to.
  std::vector<NodeMean> acc;
  std::vector<double> acc_rounding;  // rounding_of_means() of it
  std::vector<long> single;
  std::vector<PreintegratedGyroscope> turns;  // empty where all are single
  // The sensor is moved (hand-held or travelling): both sensors, of each interval.
  std::vector<PreintegratedImu> imu;
  // What gaps in between (bridged_gaps.h) and coarse rounding (coarse_rounding.h) add to each
  // interval; empty: nothing.
  std::vector<double> gyr_gap, acc_gap;
};

// The integrals of effects' columns between nodes. kKept: in memory with the rest. kOnDemand:
// computed whenever a graph asks for them, which takes time again but no memory. A graph made on
// demand refers to its recordings, plans, specification and gathered samples, which must outlive
// it.
enum class EffectJacobians { kKept, kOnDemand };

class GatheredSamples {
 public:
  // before: of the same recordings and nodes; what the specification leaves as it was is taken
  // over.
  GatheredSamples(const std::vector<const Recording*>& recordings,
                  const std::vector<NodePlan>& plans, const ModelSpec& spec,
                  const GatheredSamples* before = nullptr,
                  EffectJacobians jacobians = EffectJacobians::kKept);

  bool on_demand() const { return on_demand_; }
  // Call where on_demand(). The derivatives of what the interval from a node to the next integrates
  // to, by the effects' parameters: rotation; rotation, velocity and position.
  Eigen::Matrix<double, 3, Eigen::Dynamic> turn_by_effects(int recording, std::size_t node) const;
  Eigen::Matrix<double, 9, Eigen::Dynamic> imu_by_effects(int recording, std::size_t node) const;
  const GatheredMotion& motion(int recording) const { return (*motion_)[std::size_t(recording)]; }
  // A magnetometer's blocks, one a node.
  const std::vector<NodeMean>& mag(int recording, int sensor) const {
    return (*mag_)[std::size_t(recording)][std::size_t(sensor)];
  }

 private:
  // What intervals are integrated from, on demand.
  struct Integrals {
    Integrals(const Recording& of, const NodePlan& nodes, const ModelSpec& spec,
              const ExtendedRecording& with)
        : recording(of),
          plan(nodes),
          extended(with),
          gyr(of.gyr, spec.gyr_bias, spec.gyr_matrix_value) {}
    const Recording& recording;
    const NodePlan& plan;
    const ExtendedRecording& extended;
    IntegratedRotation gyr;
  };

  ModelSpec spec_;
  bool on_demand_;
  std::vector<std::unique_ptr<Integrals>> integrals_;
  std::shared_ptr<const std::vector<GatheredMotion>> motion_;
  std::shared_ptr<const std::vector<std::vector<std::vector<NodeMean>>>> mag_;
};

// build_model() with samples that were gathered for this specification, or for one that differs in
// noise, in nodes without a magnetometer, ...
FactorGraph build_model(const GatheredSamples& gathered,
                        const std::vector<const Recording*>& recordings,
                        const std::vector<NodePlan>& plans, const ModelSpec& spec,
                        int widened_from = 1 << 30, double widening = 1.0);

}  // namespace magimu
