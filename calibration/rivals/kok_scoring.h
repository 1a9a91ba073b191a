// SPDX-License-Identifier: BSD-3-Clause
// Maximum likelihood of Kok and Schoen by Fisher scoring: a Gauss-Newton method on the whitened
// innovations L^-1 e of the filter with their sensitivities (kok_filter.h), a few filter runs in
// all. The same matrix gives the covariance.
#pragma once

#include "calibration/rivals/kok_problem.h"
#include "solvers/levenberg_marquardt.h"

namespace magimu {

struct KokEstimate {
  KokPoint point;
  MatrixXd covariance;  // of parameters and dips (rad), the starts marginalized
  KokSums sums;         // at the point
  Result fit;           // without values
  long filter_runs = 0;
  bool singular = false;  // the data leave a combination free: the covariance says nothing there
};

// Stops where a step is below options.step_tolerance standard deviations.
KokEstimate kok_scoring(const KokProblem& problem, const KokPoint& start,
                        const OptimizerOptions& options = {});

// The covariance that the information at a point gives.
MatrixXd kok_covariance(const KokProblem& problem, const KokNormal& normal, bool* singular);

}  // namespace magimu
