// SPDX-License-Identifier: BSD-3-Clause
// What a sensor's filter does beside its delay: the sum of w(age) h(t - age) is, to second order,
// h(t - mean age) + v / 2 h'', v the variance of the ages.
#pragma once

#include <string>

#include "factors/effects/effect.h"

namespace magimu {

// s, the standard deviation of the ages: a low-pass of first order at 3 Hz.
inline constexpr double kUsualSpread = 0.05;

// v, its sigma: s^2.
std::string bandwidth_sentence(const std::string& sensor, double v, double sigma);

}  // namespace magimu
