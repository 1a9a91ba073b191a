// SPDX-License-Identifier: BSD-3-Clause
// A fit's summary with what its robust covariance is made of: by how much each block of
// CalibrationOptions::block_s moves the parameters, in the order and units of Calibration::order,
// one column a block (solvers/block_moves.h). For estimates from several recordings.
#pragma once

#include "calibration/fit/summary.h"
#include "solvers/marginals.h"

namespace magimu {

// As that without `moved` (summary.h).
Calibration summarize(const std::vector<const Recording*>& recordings, const Optimum& at,
                      const CalibrationOptions& options, MatrixXd& moved);
// The same (uncertainty.h).
void fill_uncertainty(Calibration& c, const Optimum& at, const Marginals& marginals, double block_s,
                      MatrixXd& moved);

}  // namespace magimu
