// SPDX-License-Identifier: BSD-3-Clause
// Tail probabilities of the tests' null distributions.
#pragma once

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace magimu {

// P(z > x) of a standard normal.
inline double normal_tail(double x) { return 0.5 * std::erfc(x / std::sqrt(2.0)); }

// P(X > x), X chi-square with that many degrees of freedom: finite sums (Abramowitz and Stegun
// 26.4.4 and 26.4.5).
inline double chi_square_tail(double x, int dof) {
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

// log10 P(T > x), T Student's with so many degrees of freedom.
inline double log10_student_tail(double x, double dof) {
  const boost::math::students_t t(dof);
  return std::log10(std::max(boost::math::cdf(boost::math::complement(t, x)), 1e-300));
}

}  // namespace magimu
