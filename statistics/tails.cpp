// SPDX-License-Identifier: BSD-3-Clause
#include "statistics/tails.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace magimu {

double normal_tail(double x) { return 0.5 * std::erfc(x / std::sqrt(2.0)); }

double chi_square_tail(double x, int dof) {
  if (x <= 0.0) return 1.0;
  const bool odd = dof % 2 == 1;
  double term =
      odd ? std::exp(-0.5 * x) * std::sqrt(2.0 * x / 3.14159265358979323846) : std::exp(-0.5 * x);
  double sum = odd ? std::erfc(std::sqrt(0.5 * x)) : 0.0;
  for (int k = odd ? 1 : 0; k <= dof - 2; k += 2) {
    sum += term;
    term *= x / (k + 2);
  }
  return sum;
}

double log10_chi_square_tail(double x, double dof) {
  if (!(x > 0.0) || dof <= 0.0) return 0.0;
  if (x < 600.0 + dof) {
    const double tail = boost::math::cdf(boost::math::complement(boost::math::chi_squared(dof), x));
    if (tail > 1e-290) return std::log10(tail);
  }
  // The leading term for large x: (x/2)^(dof/2 - 1) exp(-x/2) / Gamma(dof/2).
  return ((0.5 * dof - 1.0) * std::log(0.5 * x) - 0.5 * x - std::lgamma(0.5 * dof)) /
         std::log(10.0);
}

double log10_student_tail(double x, double dof) {
  const boost::math::students_t t(dof);
  return std::log10(std::max(boost::math::cdf(boost::math::complement(t, x)), 1e-300));
}

}  // namespace magimu
