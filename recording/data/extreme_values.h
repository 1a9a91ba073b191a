// SPDX-License-Identifier: BSD-3-Clause
// The largest values of one axis, sample by sample in bounded memory, and whether they show a
// converter at the end of its range: readings that should lie beyond the limit read exactly the
// limit, so that it comes many times as often as the values below it, several times in a row, and
// that more than once. Once in a row may be a device that lies still, read in coarse steps.
#pragma once

#include <array>
#include <cstddef>

namespace magimu {

class ExtremeValues {
 public:
  struct Value {
    double x = 0.0;
    std::size_t count = 0, longest_run = 0;
    std::size_t longest_held = 0;  // readings in a row while other axes moved
    int visits = 0;                // runs of which each began after the axis had read much less
    double first_s = 0.0, last_s = 0.0;
  };

  // others_moved: the sensor's other axes read otherwise than at the time before.
  void add(double t, double x, bool others_moved = false);

  // The largest one; count 0 before the first.
  const Value& top() const { return values_[0]; }
  // lively: the axis has more noise than steps, so it does not lie still by itself.
  bool looks_clipped(bool lively = true) const;
  // The largest value came often enough in a row for a limit.
  bool has_run() const;
  // The largest value comes often, and next to it hardly any.
  bool piles_up() const;

 private:
  // The largest value and the next three, falling. A peak of the motion has values just below its
  // largest one, a limit of the converter hardly any.
  std::array<Value, 4> values_;
  double last_ = 0.0, least_ = 0.0, least_since_ = 0.0;
  std::size_t run_ = 0, held_ = 0;
};

}  // namespace magimu
