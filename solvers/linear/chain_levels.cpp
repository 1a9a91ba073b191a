// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/linear/chain_levels.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace magimu {

ChainLevels::ChainLevels(const Lists& factors, std::vector<int> width)
    : variables_in_(factors),
      factors_on_(inverted(factors, int(width.size()))),
      width_(std::move(width)),
      seen_variable_(width_.size(), 0),
      seen_factor_(std::size_t(factors.size()), 0) {}

Lists ChainLevels::of(int variable) {
  // From an end; then back from the whole far end: where several variables make up a node, one
  // alone would be a level before the others of its node.
  const Lists from_here = levels_from({&variable, 1});
  Lists there = levels_from(from_here.back().first(1));
  Lists back = levels_from(there.back());
  return work(back) <= work(there) ? back : there;
}

int ChainLevels::width(std::span<const int> level) const {
  return std::accumulate(level.begin(), level.end(), 0,
                         [this](int sum, int v) { return sum + width_[std::size_t(v)]; });
}

// Breadth first.
Lists ChainLevels::levels_from(std::span<const int> start) {
  ++pass_;
  Lists levels;
  for (const int v : start) seen_variable_[std::size_t(v)] = pass_;
  levels.entries.assign(start.begin(), start.end());
  for (std::size_t next = 0; next < levels.entries.size();) {
    std::sort(levels.entries.begin() + std::ptrdiff_t(next), levels.entries.end());
    levels.close();
    for (const auto end = levels.entries.size(); next < end; ++next) {
      for (const int f : factors_on_[levels.entries[next]]) {
        if (std::exchange(seen_factor_[std::size_t(f)], pass_) == pass_) continue;
        for (const int w : variables_in_[f]) {
          if (std::exchange(seen_variable_[std::size_t(w)], pass_) == pass_) continue;
          levels.entries.push_back(w);
        }
      }
    }
  }
  return levels;
}

double ChainLevels::work(const Lists& levels) const {
  double sum = 0.0;
  for (int l = 0; l < levels.size(); ++l) sum += std::pow(double(width(levels[l])), 3);
  return sum;
}

Lists inverted(const Lists& lists, int numbers) {
  Lists out;
  std::vector<int> next(std::size_t(numbers) + 1, 0);
  for (const int n : lists.entries) ++next[std::size_t(n) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  out.begin = next;
  out.entries.resize(lists.entries.size());
  for (int i = 0; i < lists.size(); ++i) {
    for (const int n : lists[i]) out.entries[std::size_t(next[std::size_t(n)]++)] = i;
  }
  return out;
}

}  // namespace magimu
