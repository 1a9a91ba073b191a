// SPDX-License-Identifier: BSD-3-Clause
// The covariance of a sum of errors that may all have one cause. Of errors e_r with covariances C_r
// and whatever correlation, and any shares p_r that add up to 1,
//
//   cov(sum_r e_r) <= sum_r C_r / p_r
//
// with equality where they are all the same and p_r their shares. The shares here are the errors'
// sizes in standard deviations of what they are part of.
#pragma once

#include <vector>

#include "graph/scalar.h"

namespace magimu {

// covariance: of which the parts are parts, for the units.
MatrixXd covariance_of_common(const std::vector<MatrixXd>& parts, const MatrixXd& covariance);

}  // namespace magimu
