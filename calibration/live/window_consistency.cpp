// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/window_consistency.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

#include "graph/bytes.h"

namespace magimu {
namespace {

// Before enough windows were seen: the noise may be twice what is assumed, and vary as much.
constexpr double kUnknownMiddle = 1.4, kUnknownSpread = 0.7;

double upper_tail(double chi_square, double dof) {
  return boost::math::cdf(
      boost::math::complement(boost::math::chi_squared(dof), std::max(0.0, chi_square)));
}

double quantile(std::vector<double> v, double q) {
  const auto at = v.begin() + std::ptrdiff_t(q * double(v.size() - 1));
  std::nth_element(v.begin(), at, v.end());
  return *at;
}

}  // namespace

WindowFit WindowConsistency::judge(const Innovation& innovation) const {
  WindowFit fit{innovation.squares, innovation.dof, 1.0, true};
  if (innovation.dof == 0) return fit;
  const double white = std::sqrt(2.0 / innovation.dof);
  double middle = kUnknownMiddle, spread = kUnknownSpread;
  if (ratios_.size() >= kEnough) {
    const double median = quantile(ratios_, 0.5);
    middle = std::max(0.0, median);
    spread = std::max({white, (quantile(ratios_, 0.75) - median) / 0.674,
                       (quantile(ratios_, 0.85) - median) / 1.036});
  }
  const double dof = 2.0 / (spread * spread);
  fit.p_value = upper_tail(dof * innovation.squares / innovation.dof / std::exp(middle), dof);
  fit.used = fit.p_value > kLeftOut;
  return fit;
}

double WindowConsistency::overdispersion() const {
  return ratios_.size() < kFew ? 1.0 : std::max(1.0, std::exp(quantile(ratios_, 0.5)));
}

void WindowConsistency::learn(const Innovation& innovation) {
  if (innovation.dof == 0) return;
  const double ratio = std::log(std::max(innovation.squares, 1e-3) / innovation.dof);
  if (ratios_.size() < kRemembered) {
    ratios_.push_back(ratio);
  } else {
    ratios_[next_++ % kRemembered] = ratio;
  }
}

void WindowConsistency::save(ByteWriter& out) const {
  out.put(ratios_);
  out.put(std::uint64_t(next_));
}

void WindowConsistency::load(ByteReader& in) {
  in.get(ratios_);
  next_ = std::size_t(in.get<std::uint64_t>());
}

}  // namespace magimu
