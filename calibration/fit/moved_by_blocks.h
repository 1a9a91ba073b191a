// SPDX-License-Identifier: BSD-3-Clause
// A fit's summary, and what its robust covariance is made of: by how much each block of
// CalibrationOptions::block_s seconds moves the parameters. `moved` has a row for each parameter,
// in the order and units of Calibration::order, and a column for each block
// (solvers/block_moves.h). Estimates from several recordings are made of these.
#pragma once

#include "calibration/fit/summary.h"
#include "solvers/marginals.h"

namespace magimu {

// As summarize() without `moved` (summary.h).
Calibration summarize(const std::vector<const Recording*>& recordings, const Optimum& at,
                      const CalibrationOptions& options, MatrixXd& moved);
// As fill_uncertainty() without `moved` (uncertainty.h).
void fill_uncertainty(Calibration& c, const Optimum& at, const Marginals& marginals, double block_s,
                      MatrixXd& moved);

}  // namespace magimu
