// SPDX-License-Identifier: BSD-3-Clause
// The maximum of a smooth function of a few numbers, without derivatives: the next point is where a
// quadratic through the points nearest to the best one is largest, within a step that grows while
// the quadratic foretells what it finds and shrinks where it does not (Conn, Scheinberg and
// Vicente, Introduction to Derivative-Free Optimization, 2009, chapter 10). A function of three
// numbers takes some twenty calls.
#pragma once

#include <functional>
#include <vector>

namespace magimu {

struct QuadraticSearch {
  double first_step = 1.0;
  int most_calls = 100;
  std::vector<double> lower, upper;  // of each coordinate
  // A step that promises less is none.
  std::function<double(double value)> settled = {};
  int calls = 0;  // made by the last maximize()

  // x: where to start, then where the maximum is; returns that.
  double maximize(const std::function<double(const std::vector<double>&)>& f,
                  std::vector<double>& x);
};

}  // namespace magimu
