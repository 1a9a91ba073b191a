// SPDX-License-Identifier: BSD-3-Clause
// The least value of a function of one number.
#pragma once

#include <cmath>

namespace magimu {

// Where f, which falls and then rises between low and high, is least: the middle of an interval no
// longer than `tolerance` (of at most 90 steps, each of which takes 0.62 of the last).
template <class F>
double golden_section_minimum(double low, double high, double tolerance, const F& f) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kMostSteps = 90;  // far below what doubles resolve
  double x1 = high - kGolden * (high - low), x2 = low + kGolden * (high - low);
  double f1 = f(x1), f2 = f(x2);
  for (int step = 0; step < kMostSteps && high - low > tolerance; ++step) {
    if (f1 < f2) {
      high = x2, x2 = x1, f2 = f1;
      f1 = f(x1 = high - kGolden * (high - low));
    } else {
      low = x1, x1 = x2, f1 = f2;
      f2 = f(x2 = low + kGolden * (high - low));
    }
  }
  return 0.5 * (low + high);
}

}  // namespace magimu
