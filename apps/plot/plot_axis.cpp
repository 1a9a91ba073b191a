// SPDX-License-Identifier: BSD-3-Clause
#include "apps/plot/plot_axis.h"

#include <algorithm>
#include <cmath>

namespace magimu::plot {

std::vector<double> ticks(const Range& range, int at_most) {
  const double width = range.high - range.low;
  if (!(width > 0.0) || !std::isfinite(width) || at_most < 1) return {};
  const double power = std::pow(10.0, std::floor(std::log10(width / at_most)));
  for (const double step : {power, 2.0 * power, 5.0 * power, 10.0 * power, 20.0 * power}) {
    const double first = std::ceil(range.low / step - 1e-9);
    const double last = std::floor(range.high / step + 1e-9);
    if (last - first + 1.0 > at_most) continue;
    std::vector<double> out;
    // Counted from the first: beyond 2^53 a double does not change by 1.
    for (double k = 0.0; k <= last - first; k += 1.0) {
      out.push_back(first + k == 0.0 ? 0.0 : (first + k) * step);
    }
    return out;
  }
  return {};
}

std::vector<double> log_ticks(const Range& range) {
  if (!(range.low > 0.0 && range.high > range.low)) return {};
  constexpr int kMostDecades = 8;
  const bool few = range.high / range.low < 2e3;
  // Over many decades only every second, third, ... power.
  const int every = 1 + int(std::log10(range.high / range.low)) / kMostDecades;
  std::vector<double> out;
  for (int e = int(std::floor(std::log10(range.low))); e <= int(std::log10(range.high)) + 1; ++e) {
    if (e % every != 0) continue;
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, e);
      if ((digit == 1.0 || few) && value >= range.low && value <= range.high) out.push_back(value);
    }
  }
  return out;
}

bool Axis::shows(double value) const { return std::isfinite(value) && (!log || value > 0.0); }

double Axis::operator()(double value) const {
  const auto scaled = [this](double v) { return log ? std::log10(v) : v; };
  const double v = std::clamp(value, range.low, range.high);
  const double low = scaled(range.low), high = scaled(range.high);
  return begin + (end - begin) * (scaled(v) - low) / (high - low);
}

void Extent::add(const std::vector<double>& values) {
  for (const double v : values) {
    if (!std::isfinite(v) || (log_ && v <= 0.0)) continue;
    const bool first = low_ > high_;
    low_ = first ? v : std::min(low_, v);
    high_ = first ? v : std::max(high_, v);
  }
}

Range Extent::range(double air) const {
  if (low_ > high_) return log_ ? Range{0.1, 1.0} : Range{};
  if (log_) return {low_ / 1.2, high_ * 1.2};
  // Zero belongs to the picture where it is near.
  const bool from_zero = low_ >= 0.0 && low_ < 0.5 * high_ && air > 0.0;
  const double width = high_ > low_ ? high_ - low_ : std::max(1.0, std::abs(high_));
  return {from_zero ? 0.0 : low_ - air * width, high_ > low_ ? high_ + air * width : low_ + width};
}

}  // namespace magimu::plot
