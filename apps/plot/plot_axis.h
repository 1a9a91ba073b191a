// SPDX-License-Identifier: BSD-3-Clause
// An axis of a picture (plot.h): which range, which ticks, where a value is.
#pragma once

#include <vector>

namespace magimu::plot {

struct Range {
  double low = 0.0, high = 1.0;
};

// Round numbers (1, 2 or 5 times a power of ten apart) within the range, at most so many.
std::vector<double> ticks(const Range& range, int at_most);
// On a logarithmic axis: powers of ten, with 2 and 5 times these where there are few; not all where
// there are many.
std::vector<double> log_ticks(const Range& range);

// From values to pixels.
struct Axis {
  Range range;
  bool log = false;
  double begin = 0.0, end = 1.0;  // pixels of range.low, range.high

  // False for what has no place on it: not a number, on a logarithmic axis not positive.
  bool shows(double value) const;
  // Values beyond the range lie at its ends.
  double operator()(double value) const;
};

// Finds the range that holds all values given to it.
class Extent {
 public:
  explicit Extent(bool log = false) : log_(log) {}
  void add(const std::vector<double>& values);
  // air: what is left free beyond the values, as a share of their range.
  Range range(double air) const;

 private:
  bool log_;
  double low_ = 0.0, high_ = -1.0;  // low > high: none yet
};

}  // namespace magimu::plot
