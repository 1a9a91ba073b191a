// SPDX-License-Identifier: BSD-3-Clause
// The samples of a sensor gathered about the nodes: each falls to the node nearest in time, and a
// node keeps their mean with the mean rotation C from its own frame to theirs, so that
// mean(R_k' x) = C R_node' x for any vector x of n.
#pragma once

#include "calibration/integrated_rotation.h"
#include "calibration/nodes.h"

namespace magimu {

struct Block {
  int count = 0;
  std::size_t first = 0;  // its first sample
  Vector3 mean = Vector3::Zero();
  Matrix3 C = Matrix3::Zero();
  // d C / d tau where the samples show the attitude tau seconds ago: mean of [omega]x R_k' R_node.
  Matrix3 C_rate = Matrix3::Zero();
  bool at_node = false;  // one sample, at the node's very time: C is the identity
};

// Hands out blocks node after node.
class BlockMeans {
 public:
  // offset_s: how long ago the attitude was that a sample shows (tau). All must outlive this.
  BlockMeans(const VectorSeries& series, const IntegratedRotation& gyr, const NodePlan& plan,
             double offset_s = 0.0);

  // The block of node 0, then of node 1, ...
  Block next();

 private:
  const VectorSeries& series_;
  const IntegratedRotation& gyr_;
  const NodePlan& plan_;
  double offset_s_;
  std::size_t sample_ = 0, node_ = 0;
};

}  // namespace magimu
