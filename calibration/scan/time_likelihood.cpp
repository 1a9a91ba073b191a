// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/time_likelihood.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace magimu {

std::size_t LikelyTimes::best() const {
  return std::size_t(std::ranges::max_element(gain) - gain.begin());
}

void TimeLikelihood::take(LikelyTimes finest) {
  const std::size_t best = finest.best();
  const double moved = finest.t[best] - t_, lower = std::exp(-finest.gain[best]);
  beyond_ = {.mass = lower * beyond_.mass,
             .first = lower * (beyond_.first - moved * beyond_.mass),
             .second = lower * (beyond_.second - 2.0 * moved * beyond_.first +
                                moved * moved * beyond_.mass)};
  t_ = finest.t[best];
  finest_ = std::move(finest);
}

void TimeLikelihood::narrow(double within_s) {
  LikelyTimes near = {.grid_s = finest_.grid_s};
  for (std::size_t i = 0; i < finest_.t.size(); ++i) {
    const double off_s = finest_.t[i] - t_;
    if (std::abs(off_s) > within_s) {
      beyond_.add(off_s, weight_s(i));
    } else {
      near.t.push_back(finest_.t[i]);
      near.gain.push_back(finest_.gain[i]);
    }
  }
  finest_ = std::move(near);
}

double TimeLikelihood::sigma_s() const {
  const Share share = all();
  return share.mass > 0.0 ? std::sqrt(share.second / share.mass) : 0.0;
}

double TimeLikelihood::width_s() const { return all().mass; }

void TimeLikelihood::Share::add(double off_s, double weight_s) {
  mass += weight_s;
  first += weight_s * off_s;
  second += weight_s * off_s * off_s;
}

double TimeLikelihood::weight_s(std::size_t i) const {
  return finest_.grid_s * std::exp(finest_.gain[i] - finest_.gain[finest_.best()]);
}

TimeLikelihood::Share TimeLikelihood::all() const {
  Share out = beyond_;
  for (std::size_t i = 0; i < finest_.t.size(); ++i) out.add(finest_.t[i] - t_, weight_s(i));
  return out;
}

}  // namespace magimu
