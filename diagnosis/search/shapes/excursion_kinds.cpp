// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/shapes/excursion_kinds.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kConcentrated = 0.1;  // share of squares across the line, below which axes agree

}  // namespace

double log10_p_of_lines(const Matrix3& moments, double n) {
  const Vector3 share = Eigen::SelfAdjointEigenSolver<Matrix3>(moments).eigenvalues();
  const double across = std::max(1e-12, share[0] + share[1]);
  if (across < kConcentrated) {
    // Of axes that are nearly one: n sums of squares of two small angles about a mean axis that may
    // have any direction, uniform over half a sphere each: a ball of 2 (n - 1) dimensions.
    // Bingham's approximation below is never less than 0.01 for three axes.
    const double p = std::log10(n) + (n - 1.0) * std::log10(0.5 * n * across) -
                     std::lgamma(n) / std::log(10.0) - 0.5 * n * std::log10(1.0 - across);
    return std::min(0.0, p);
  }
  // Bingham 1974, for many axes.
  const double statistic = 7.5 * n * (share.array() - 1.0 / 3.0).square().sum();
  return log10_chi_square_tail(statistic, 5.0);
}

double log_odds_of_turns(const std::vector<AlongField>& excursions, double usual) {
  // An excursion's residuals have one direction, more or less: one direction each is counted.
  // If it is any, the square s of its cosine with the field has the density 1 / (2 sqrt(s)). If the
  // field only turns, its size departs by what it does elsewhere: along / (samples usual) is
  // chi-square with one degree of freedom.
  double out = 0.0;
  for (const AlongField& e : excursions) {
    const double expected = e.samples * usual;
    out += 0.5 * std::log(2.0 * e.all / (M_PI * expected)) - 0.5 * e.along / expected;
  }
  return out;
}

}  // namespace magimu
