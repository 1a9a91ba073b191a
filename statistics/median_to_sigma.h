// SPDX-License-Identifier: BSD-3-Clause
// From a median of absolute values to a standard deviation, which a few wild values cannot change.
#pragma once

namespace magimu {

// 1 / (the 75 % quantile of a normal distribution): the standard deviation of normal numbers with
// mean 0 over the median of their absolute values.
inline constexpr double kMedianToSigma = 1.4826;

}  // namespace magimu
