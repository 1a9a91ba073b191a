// SPDX-License-Identifier: BSD-3-Clause
// What a share of some numbers lie below.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace magimu {

// Of n numbers in order the one at place floor(share n), counted from 0, at most the last;
// 0 <= share. 0 of none.
template <class T>
T quantile(std::vector<T> values, double share) {
  if (values.empty()) return T(0);
  const auto place = std::size_t(share * double(values.size()));
  const auto at = values.begin() + std::ptrdiff_t(std::min(place, values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Of an even number of them the mean of the two in the middle. 0 of none.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*std::max_element(values.begin(), middle) + *middle);
}

}  // namespace magimu
