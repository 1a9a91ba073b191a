// SPDX-License-Identifier: BSD-3-Clause
// The four cubic B-splines that reach into an interval, and their derivatives: spline.h.
#include "sim/motions/spline.h"

#include <algorithm>
#include <array>

namespace magimu {
namespace {

// Weights of the coefficients knot - 3 .. knot at the fraction u of the interval.
std::array<double, 4> weights(double u, int derivative) {
  const double v = 1.0 - u;
  switch (derivative) {
    case 0:
      return {v * v * v / 6.0, (4.0 - 3.0 * u * u * (2.0 - u)) / 6.0,
              (4.0 - 3.0 * v * v * (2.0 - v)) / 6.0, u * u * u / 6.0};
    case 1:
      return {-0.5 * v * v, u * (1.5 * u - 2.0), -v * (1.5 * v - 2.0), 0.5 * u * u};
    default:
      return {v, 3.0 * u - 2.0, 3.0 * v - 2.0, u};
  }
}

}  // namespace

Spline::Reach Spline::reach(double t, int derivative) const {
  const int count = static_cast<int>(coefficient.size());
  const double per_s = (count + 3) / (end - start);  // knot intervals
  const double x = (t - start) * per_s;
  const int knot = std::clamp(static_cast<int>(x), 0, count + 2);
  Reach out{knot - 3, weights(x - knot, derivative)};
  for (int i = 0; i < derivative; ++i) {
    for (double& w : out.weight) w *= per_s;
  }
  return out;
}

Vector3 Spline::at(double t, int derivative) const {
  Vector3 sum = Vector3::Zero();
  if (t <= start || t >= end || coefficient.empty()) return sum;
  const Reach r = reach(t, derivative);
  for (int i = 0; i < 4; ++i) {
    const int j = r.first + i;
    if (j < 0 || j >= static_cast<int>(coefficient.size())) continue;
    sum += r.weight[std::size_t(i)] * coefficient[std::size_t(j)];
  }
  return sum;
}

}  // namespace magimu
