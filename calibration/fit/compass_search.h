// SPDX-License-Identifier: BSD-3-Clause
// The maximum of a smooth function of a few numbers, without derivatives: along one coordinate
// after the other. Where three points show a top between them, the next point is the top of their
// parabola; else the step becomes longer.
#pragma once

#include <functional>
#include <vector>

namespace magimu {

struct CompassSearch {
  double first_step = 1.0;
  int most_calls = 100;
  std::vector<double> lower, upper;                  // of each coordinate
  std::function<double(double value)> settled = {};  // a round that gains less is the last
  int calls = 0;                                     // made by the last maximize()

  // x: where to start, then where the maximum is; returns that.
  double maximize(const std::function<double(const std::vector<double>&)>& f,
                  std::vector<double>& x);
};

}  // namespace magimu
