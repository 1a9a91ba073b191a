// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/window_consistency.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace magimu {
namespace {

constexpr double kQuartiles = 1.349;  // of a normal distribution, in sigmas apart

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
  double middle = 0.0, spread = white;
  if (!ratios_.empty()) {
    middle = std::max(0.0, quantile(ratios_, 0.5));
    spread = std::max(white, (quantile(ratios_, 0.75) - quantile(ratios_, 0.25)) / kQuartiles);
  }
  const double dof = 2.0 / (spread * spread);
  fit.p_value = upper_tail(dof * innovation.squares / innovation.dof / std::exp(middle), dof);
  fit.used = fit.p_value > kLeftOut;
  return fit;
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

}  // namespace magimu
