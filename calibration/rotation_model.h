// SPDX-License-Identifier: BSD-3-Clause
// The paper's model as a graph: the sensor only turns. A node is the orientation at a magnetometer
// sample (every one, or every n-th with all samples averaged in blocks about the nodes); between
// nodes stands the gyroscope, at the nodes the accelerometer and every magnetometer. Several
// recordings of one device share biases and distortion; each has its own dip.
#pragma once

#include <vector>

#include "calibration/integrated_rotation.h"
#include "factors/keys.h"
#include "factors/sensor_model.h"
#include "graph/factor_graph.h"

namespace magimu {

// Where the nodes of one recording are.
struct NodePlan {
  std::vector<double> t;  // node times, s: increasing, within the gyroscope's span
  int first = 0;          // its poses are R(first), R(first + 1), ...
};

// Nodes at every `every`-th sample of magnetometer 0 that lies within the gyroscope's span.
std::vector<NodePlan> plan_nodes(const std::vector<const Recording*>& recordings, int every);

// The dip of one recording: alpha, rad.
constexpr Key dip_of(int recording) { return {key::dip.symbol, std::uint32_t(recording)}; }

struct RotationModel {
  FactorGraph graph;
  Vector3 integrated_at;  // the gyroscope bias at which rates were integrated
};

// gyr_bias: where to integrate the gyroscope.
RotationModel build_rotation_model(const std::vector<const Recording*>& recordings,
                                   const std::vector<NodePlan>& plans, const Vector3& gyr_bias,
                                   const NoiseDensities& noise, double gravity);

}  // namespace magimu
