// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/compass_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace magimu {
namespace {

constexpr double kLonger = 2.0;    // a step that helped
constexpr double kLeast = 0.02;    // a step, and what the top of a parabola is kept from an end
constexpr double kShorter = 0.35;  // steps after a round

}  // namespace

double CompassSearch::maximize(const std::function<double(const std::vector<double>&)>& f,
                               std::vector<double>& x) {
  calls = 0;
  const auto value = [&](std::size_t i, double to) {
    ++calls;
    std::vector<double> at = x;
    at[i] = to;
    return f(at);
  };
  std::vector<double> step(x.size(), first_step);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::clamp(x[i], lower[i], upper[i]);
  double best = value(0, x[0]);
  while (calls < most_calls) {
    const double before = best;
    for (std::size_t i = 0; i < x.size() && calls < most_calls; ++i) {
      // Three points, the middle one no lower than the others.
      double middle = x[i], left = std::max(lower[i], middle - step[i]),
             right = std::min(upper[i], middle + step[i]);
      double at_middle = best, at_left = left < middle ? value(i, left) : -INFINITY,
             at_right = right > middle ? value(i, right) : -INFINITY;
      while (std::max(at_left, at_right) > at_middle && calls < most_calls) {
        step[i] *= kLonger;
        if (at_right >= at_left) {
          left = middle, at_left = at_middle;
          middle = right, at_middle = at_right;
          right = std::min(upper[i], middle + step[i]);
          at_right = right > middle ? value(i, right) : -INFINITY;
        } else {
          right = middle, at_right = at_middle;
          middle = left, at_middle = at_left;
          left = std::max(lower[i], middle - step[i]);
          at_left = left < middle ? value(i, left) : -INFINITY;
        }
      }
      double top = middle;
      if (std::isfinite(at_left) && std::isfinite(at_right)) {
        // Newton's divided differences.
        const double p = (at_middle - at_left) / (middle - left),
                     q = (at_right - at_middle) / (right - middle),
                     curvature = (q - p) / (right - left);
        if (curvature < 0.0) top = 0.5 * (left + middle) - 0.5 * p / curvature;
        top = std::clamp(top, left, right);
      }
      x[i] = middle;
      best = at_middle;
      if (std::abs(top - middle) > kLeast * step[i]) {
        if (const double at_top = value(i, top); at_top > best) {
          x[i] = top;
          best = at_top;
        }
      }
      step[i] = std::max(kLeast, kShorter * step[i]);
    }
    if (best - before < settled(best)) break;
  }
  return best;
}

}  // namespace magimu
