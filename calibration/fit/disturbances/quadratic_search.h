// SPDX-License-Identifier: BSD-3-Clause
// The maximum of a smooth function of a few numbers between bounds, by values alone: slopes are
// differences over a tenth of a unit of curvature, second derivatives are learned from how slopes
// change (BFGS, damped) and from steps that found less than they promised; each step goes to the
// top of that quadratic within a region that grows and shrinks with what it foretells (Nocedal and
// Wright, Numerical Optimization, 2006, chapters 4, 6, 8 and procedure 18.2). A function of three
// numbers takes some forty calls, and some eight near a maximum whose curvature is known.
#pragma once

#include <functional>
#include <vector>

#include "graph/variable.h"

namespace magimu {

struct QuadraticSearch {
  double first_step = 1.0;
  int most_calls = 100;              // looked at before each round: a few more may be made
  std::vector<double> lower, upper;  // of each coordinate
  // The search ends where the quadratic promises less than this gain, a function of the value.
  std::function<double(double value)> settled = {};
  // Minus the second derivatives at the start, positive definite, where they are known; of another
  // size, such as empty: not. Then those where the search ended.
  MatrixXd curvature = {};
  // Whether curvatures that were only learned on the way are measured before the end.
  bool confirms = true;
  int calls = 0;  // made by the last maximize()

  // x: where to start, then where the maximum is; returns that.
  double maximize(const std::function<double(const std::vector<double>&)>& f,
                  std::vector<double>& x);
};

}  // namespace magimu
