// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/extreme_values.h"

#include <algorithm>

namespace magimu {
namespace {

constexpr std::size_t kClippedRun = 3;     // equal extreme values in a row
constexpr std::size_t kClippedTotal = 10;  // and in all
constexpr double kClippedSpike = 3.0;      // times as often as all next values together
constexpr int kClippedVisits = 2, kClippedVisitsCoarse = 6;
constexpr double kMuchLess = 0.05;  // of the axis's span

}  // namespace

void ExtremeValues::add(double t, double x, bool others_moved) {
  if (run_ == 0) least_ = least_since_ = x;
  least_ = std::min(least_, x);
  least_since_ = std::min(least_since_, x);
  const bool again = run_ > 0 && x == last_;
  run_ = again ? run_ + 1 : 1;
  held_ = !again ? 0 : others_moved ? held_ + 1 : held_;
  last_ = x;
  auto at = std::ranges::find_if(values_, [x](const Value& v) { return v.count == 0 || v.x <= x; });
  if (at == values_.end()) return;
  if (at->count == 0 || at->x < x) {
    std::move_backward(at, values_.end() - 1, values_.end());
    *at = {x, 0, 0, 0, 0, t, t};
  }
  if (at == values_.begin() && run_ == kClippedRun) {
    if (at->visits == 0 || x - least_since_ > kMuchLess * (x - least_)) ++at->visits;
    least_since_ = x;
  }
  ++at->count;
  at->longest_run = std::max(at->longest_run, run_);
  at->longest_held = std::max(at->longest_held, held_);
  at->last_s = t;
}

bool ExtremeValues::has_run() const { return top().longest_run >= kClippedRun; }

bool ExtremeValues::piles_up() const {
  std::size_t next = 0;
  for (std::size_t i = 1; i < values_.size(); ++i) next += values_[i].count;
  return top().count >= kClippedTotal && double(top().count) >= kClippedSpike * double(next);
}

bool ExtremeValues::looks_clipped(bool lively) const {
  return piles_up() && has_run() &&
         top().visits >= (lively ? kClippedVisits : kClippedVisitsCoarse);
}

}  // namespace magimu
