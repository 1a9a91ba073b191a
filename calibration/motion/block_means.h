// SPDX-License-Identifier: BSD-3-Clause
// The samples of a sensor gathered about the nodes: each falls to the node nearest in time, and a
// node keeps their mean with the mean rotation C from its own frame to theirs, so that
// mean(R_k' x) = C R_node' x for any vector x of n.
#pragma once

#include "calibration/motion/integrated_rotation.h"
#include "calibration/motion/nodes.h"

namespace magimu {

// The mean of a node's samples, and what their attitudes have to do with the node's.
struct NodeMean {
  int count = 0;
  double independent = 0.0;  // of these samples: what its mean's noise is that of
  std::size_t first = 0;     // its first sample
  Vector3 mean = Vector3::Zero();
  Matrix3 C = Matrix3::Zero();
  // d C / d tau where the samples show the attitude tau seconds ago: mean of [omega]x R_k' R_node.
  Matrix3 C_rate = Matrix3::Zero();
  bool at_node = false;  // one sample, at the node's very time: C is the identity
};

// The first sample of each node, and last where the last node's end.
std::vector<std::size_t> samples_of_nodes(const VectorSeries& series, const NodePlan& plan);

// The mean at each node. offset_s: how long ago the attitude was that a sample shows (tau).
std::vector<NodeMean> node_means(const VectorSeries& series, const IntegratedRotation& gyr,
                                 const NodePlan& plan, double offset_s = 0.0);

}  // namespace magimu
