// SPDX-License-Identifier: BSD-3-Clause
// Kok and Schoen's maximum likelihood as code published with Huang et al. 2025 runs it: a general
// BFGS method on unscaled parameters, from the identity, with forward differences, stopped by its
// default limit of evaluations; log det S weighs 1, where the likelihood has 1/2. For comparisons
// with published figures; kok_scoring.h finds the optimum that this one is stopped before.
#pragma once

#include "calibration/rivals/kok_scoring.h"

namespace magimu {

struct KokPublishedOptions {
  // Evaluations of the objective: a hundred a parameter, as that optimizer's default. 0: no limit.
  int evaluations_per_parameter = 100;
  double log_det_weight = 2.0;  // in kok_objective(): 1 is the likelihood's
};

// problem: without unknown starts. The covariance is that of the likelihood at the point.
KokEstimate kok_published(const KokProblem& problem, const KokPoint& start,
                          const KokPublishedOptions& options = {});

}  // namespace magimu
