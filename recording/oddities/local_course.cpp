// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/local_course.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

// Of a linear predictor with least squares: residuals without the neighbour i are those with it
// and H_ji e_i / (1 - h_i) more, so that one factorization serves all that are left out.
constexpr int kMostTerms = 4;
constexpr double kAllOfIt = 1e-9;  // of 1 - h_i: the neighbour that alone determines the course

using Powers =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, int(kMostNeighbours), kMostTerms>;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, int(kMostNeighbours), 1>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, int(kMostNeighbours),
                             int(kMostNeighbours)>;

}  // namespace

LocalCourse local_course(std::span<const double> t, std::span<const Vector3* const> v) {
  const int n = int(t.size()), terms = std::clamp(n / 2, 2, kMostTerms);
  double longest = 0.0;
  for (const double x : t) longest = std::max(longest, std::abs(x));
  Powers A(n, terms);
  for (int i = 0; i < n; ++i) {
    double power = 1.0;
    for (int j = 0; j < terms; ++j, power *= t[std::size_t(i)] / longest) A(i, j) = power;
  }
  const Eigen::HouseholderQR<Powers> qr(A);
  const Powers Q = qr.householderQ() * Powers::Identity(n, terms);
  // The course at 0 is weights' x.
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostTerms, 1> first(terms);
  first.setZero();
  first[0] = 1.0;
  const auto R = qr.matrixQR().topRows(terms).template triangularView<Eigen::Upper>();
  R.transpose().solveInPlace(first);
  const Column weights = Q * first;
  const Square H = Q * Q.transpose();
  const double freedom = std::max(1, n - 1 - terms);
  LocalCourse out;
  for (int axis = 0; axis < 3; ++axis) {
    Column x(n);
    for (int i = 0; i < n; ++i) x[i] = (*v[std::size_t(i)])[axis];
    Column e = x - H * x;
    int worst = 0;
    double most = -1.0;
    for (int i = 0; i < n; ++i) {
      const double left = std::max(kAllOfIt, 1.0 - H(i, i)), loss = e[i] * e[i] / left;
      if (loss > most) {
        most = loss;
        worst = i;
      }
    }
    const double alone = e[worst] / std::max(kAllOfIt, 1.0 - H(worst, worst));
    out.middle[axis] = weights.dot(x) - weights[worst] * alone;
    e += alone * H.col(worst);
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < n; ++i) {
      if (i == worst) continue;
      low = std::min(low, e[i]);
      high = std::max(high, e[i]);
    }
    // Weights without it: it has passed its own on.
    const double share = weights[worst] / std::max(kAllOfIt, 1.0 - H(worst, worst));
    Column own = weights + share * H.col(worst);
    own[worst] = 0.0;
    out.spread[axis] =
        (high - low) * std::sqrt(double(n - 1) / freedom) * std::sqrt(1.0 + own.squaredNorm());
  }
  return out;
}

}  // namespace magimu
