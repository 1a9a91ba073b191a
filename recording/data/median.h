// SPDX-License-Identifier: BSD-3-Clause
// What half of some numbers are below: of an even number of them, the mean of the two in the
// middle.
#pragma once

#include <algorithm>
#include <vector>

namespace magimu {

// 0 of none.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*std::max_element(values.begin(), middle) + *middle);
}

}  // namespace magimu
