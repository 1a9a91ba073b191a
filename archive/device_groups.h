// SPDX-License-Identifier: BSD-3-Clause
// The recordings of one device as a problem of changes: in coordinates about the joint estimate,
// scaled, with the groups of parameters that change together.
#pragma once

#include "archive/change_model.h"
#include "archive/joint_estimate.h"

namespace magimu {

struct DeviceProblem {
  ChangeProblem changes;
  VectorXd scale;                // a coordinate's unit
  std::vector<MatrixXd> weight;  // robust information of each recording, own coordinates
};

// recordings and shared: sorted by name; order: the order of time, indices into them. time: of each
// in that order.
DeviceProblem device_problem(const std::vector<RecordingSummary>& recordings,
                             const SharedParameters& shared, const VectorXd& joint,
                             const std::vector<std::size_t>& order,
                             const std::vector<double>& time);

}  // namespace magimu
