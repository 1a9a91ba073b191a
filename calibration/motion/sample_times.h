// SPDX-License-Identifier: BSD-3-Clause
// Looking up samples by time: most recordings are evenly sampled, so the right place is next to
// where even sampling would have it.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace magimu {

// How many of these increasing times are not later than `at`: std::upper_bound, but faster.
inline std::size_t count_until(const std::vector<double>& t, double at) {
  constexpr std::ptrdiff_t kNear = 4;
  const auto n = std::ptrdiff_t(t.size());
  if (n > 1 && at >= t.front() && at < t.back()) {
    auto k = std::ptrdiff_t((at - t.front()) / (t.back() - t.front()) * double(n - 1)) + 1;
    const auto least = std::max<std::ptrdiff_t>(k - kNear, 1), most = std::min(k + kNear, n - 1);
    k = std::min(k, n - 1);
    while (k < most && t[std::size_t(k)] <= at) ++k;
    while (k > least && t[std::size_t(k) - 1] > at) --k;
    if (t[std::size_t(k) - 1] <= at && t[std::size_t(k)] > at) return std::size_t(k);
  }
  return std::size_t(std::upper_bound(t.begin(), t.end(), at) - t.begin());
}

// The last sample not later than `at`; 0 where all are later.
inline std::size_t sample_until(const std::vector<double>& t, double at) {
  const std::size_t n = count_until(t, at);
  return n > 0 ? n - 1 : 0;
}

constexpr double kUneven = 0.1;  // of an interval: derivatives are not taken across

// Does a sample stand as far from the one before it as from the one after?
inline bool is_evenly_spaced(const std::vector<double>& t, std::size_t k) {
  if (k == 0 || k + 1 >= t.size()) return false;
  const double before = t[k] - t[k - 1], after = t[k + 1] - t[k];
  return std::abs(after - before) <= kUneven * before;
}

}  // namespace magimu
