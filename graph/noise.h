// SPDX-License-Identifier: BSD-3-Clause
// How sure a factor is of its residual. Gaussian noise turns a residual e with covariance S into a
// whitened one, r = W e with W'W = S^-1, of unit covariance; a robust loss then lets single large
// residuals count less. The cost of a factor is rho(r'r) / 2, which is r'r / 2 without a loss.
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "graph/scalar.h"

namespace magimu {

// rho(s) of the squared whitened norm s, its derivative being the weight the factor keeps.
//   none    rho = s
//   huber   s where s <= k^2, else 2 k sqrt(s) - k^2          (linear growth)
//   cauchy  k^2 log(1 + s / k^2)                              (logarithmic growth)
//   tukey   k^2 / 3 (1 - (1 - s / k^2)^3) where s <= k^2, else k^2 / 3   (outliers drop out)
struct Loss {
  enum class Kind { kNone, kHuber, kCauchy, kTukey };
  Kind kind = Kind::kNone;
  double k = 1.0;  // whitened residual norm at which the loss departs from the square

  // k: usual values keep 95 % efficiency for a scalar Gaussian residual.
  static Loss huber(double k = 1.345) { return {Kind::kHuber, checked(k)}; }
  static Loss cauchy(double k = 2.385) { return {Kind::kCauchy, checked(k)}; }
  static Loss tukey(double k = 4.685) { return {Kind::kTukey, checked(k)}; }

  double rho(double s) const {
    const double k2 = k * k;
    switch (kind) {
      case Kind::kHuber:
        return s <= k2 ? s : 2.0 * k * std::sqrt(s) - k2;
      case Kind::kCauchy:
        return k2 * std::log1p(s / k2);
      case Kind::kTukey: {
        const double x = std::min(1.0, s / k2);  // multiplied out: small s keep their digits
        return k2 * x * (1.0 - x * (1.0 - x / 3.0));
      }
      case Kind::kNone:
        break;
    }
    return s;
  }
  double weight(double s) const {
    const double k2 = k * k;
    switch (kind) {
      case Kind::kHuber:
        return s <= k2 ? 1.0 : k / std::sqrt(s);
      case Kind::kCauchy:
        return 1.0 / (1.0 + s / k2);
      case Kind::kTukey: {
        const double u = 1.0 - std::min(1.0, s / k2);
        return u * u;
      }
      case Kind::kNone:
        break;
    }
    return 1.0;
  }

 private:
  static double checked(double k) {
    if (!(k > 0.0)) throw std::invalid_argument("a robust loss needs a positive threshold k");
    return k;
  }
};

namespace detail {
// W = L^-1 of the n x n covariance S = L L', both column by column; false if S is not positive
// definite, not symmetric or not finite. One function for all n: a decomposition each would take
// compilers long.
bool find_whitening(const double* covariance, int n, double* whitening);
}  // namespace detail

template <int N>
class Noise {
 public:
  // Standard deviation 1 in every component.
  Noise() : whitening_(Mat<double, N, N>::Identity()) {}

  static Noise isotropic(double sigma) { return diagonal(Vec<double, N>::Constant(sigma)); }
  static Noise diagonal(const Vec<double, N>& sigmas) {
    if (!(sigmas.minCoeff() > 0.0) || !sigmas.allFinite()) {
      throw std::invalid_argument("noise needs positive, finite standard deviations");
    }
    Noise n;
    n.whitening_ = sigmas.cwiseInverse().asDiagonal();
    return n;
  }
  static Noise full(const Mat<double, N, N>& covariance) {
    Noise n;
    n.diagonal_ = false;
    if (!detail::find_whitening(covariance.data(), N, n.whitening_.data())) {
      throw std::invalid_argument("noise needs a symmetric, positive definite covariance");
    }
    return n;
  }
  Noise with_loss(Loss loss) const {
    Noise n = *this;
    n.loss_ = loss;
    return n;
  }

  // W, lower triangular, with W'W the inverse of the covariance.
  const Mat<double, N, N>& whitening() const { return whitening_; }
  bool is_diagonal() const { return diagonal_; }
  const Loss& loss() const { return loss_; }
  // -log sqrt(det S), for likelihoods.
  double log_det_whitening() const { return whitening_.diagonal().array().log().sum(); }

  // Multiplies columns of N rows by W.
  template <class Derived>
  void whiten(Eigen::MatrixBase<Derived>& columns) const {
    if (diagonal_) {
      columns.array().colwise() *= whitening_.diagonal().array();
      return;
    }
    // In place, from the last row up: W is a lower triangle. Loops, for an unrolled product of each
    // size would take compilers long.
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      for (int r = N - 1; r >= 0; --r) {
        typename Derived::Scalar sum = whitening_(r, r) * columns(r, c);
        for (int k = 0; k < r; ++k) sum += whitening_(r, k) * columns(k, c);
        columns(r, c) = sum;
      }
    }
  }

 private:
  bool diagonal_ = true;
  Mat<double, N, N> whitening_;
  Loss loss_;
};

}  // namespace magimu
