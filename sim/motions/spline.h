// SPDX-License-Identifier: BSD-3-Clause
// A uniform cubic B-spline in time, 0 outside of a stretch and, with its first two derivatives, at
// both ends of it:
//
//   f(t) = sum_j c_j B((t - start) / h - j),   h = (end - start) / (count + 3)
//
// so what it describes starts and ends at rest.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "graph/scalar.h"

namespace magimu {

struct Spline {
  double start = 0.0, end = 0.0;     // s
  std::vector<Vector3> coefficient;  // c_j

  // Coefficients that a stretch of that length has room for, knots at least interval_s apart.
  static int room(double length_s, double interval_s) {
    return std::max(0, static_cast<int>(length_s / interval_s) - 3);
  }
  // The derivative of the given order (0, 1 or 2) at time t.
  Vector3 at(double t, int derivative = 0) const;

  // The same as a sum over coefficients first .. first + 3, of which those that are not there count
  // as 0; t between start and end.
  struct Reach {
    int first;
    std::array<double, 4> weight;
  };
  Reach reach(double t, int derivative = 0) const;
};

}  // namespace magimu
