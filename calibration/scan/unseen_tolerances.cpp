// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/unseen_tolerances.h"

#include <algorithm>
#include <cmath>

#include "graph/decompositions.h"

namespace magimu {
namespace {

// Of independent directions: the logarithm of the odds of an error, at even odds beforehand; mean
// and variance of the error where it is there.
struct Directions {
  VectorXd log_odds, mean, variance;
};

// E[x x'], over all sets of directions that may have an error. Their number is at most 2^9.
MatrixXd second_moment(const Directions& d) {
  const auto n = int(d.mean.size());
  const unsigned sets = 1u << n;
  VectorXd log_p(sets);
  for (unsigned set = 0; set < sets; ++set) {
    int k = 0;
    log_p[set] = 0.0;
    for (int i = 0; i < n; ++i) {
      if ((set >> i & 1u) == 0) continue;
      log_p[set] += d.log_odds[i];
      ++k;
    }
    // Each k is as probable, and each set of k directions.
    log_p[set] += std::lgamma(k + 1.0) + std::lgamma(n - k + 1.0);
  }
  const VectorXd p = (log_p.array() - log_p.maxCoeff()).exp();
  MatrixXd sum = MatrixXd::Zero(n, n);
  for (unsigned set = 0; set < sets; ++set) {
    VectorXd mean = VectorXd::Zero(n);
    for (int i = 0; i < n; ++i) {
      if ((set >> i & 1u) == 0) continue;
      mean[i] = d.mean[i];
      sum(i, i) += p[set] * d.variance[i];
    }
    sum += p[set] * mean * mean.transpose();
  }
  return sum / p.sum();
}

}  // namespace

bool is_tolerance(const Effect& effect) {
  return effect.name() == "acc_scale_misalignment" || effect.name() == "gyro_scale_misalignment" ||
         effect.name() == "gyro_g_sensitivity";
}

MatrixXd unseen_tolerances(const MatrixXd& A, const VectorXd& z, double excess,
                           const VectorXd& sigma) {
  const MatrixXd scaled = sigma.asDiagonal() * A * sigma.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd((0.5 / excess) * (scaled + scaled.transpose())));
  const MatrixXd LU = sigma.asDiagonal() * eigen.eigenvectors();
  const VectorXd y = LU.transpose() * z / excess;
  const Eigen::Index n = y.size();
  Directions d{VectorXd(n), VectorXd(n), VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double lambda = std::max(0.0, eigen.eigenvalues()[i]), there = 1.0 + lambda;
    // A score has the information as its variance: without information it is rounding.
    const double score = lambda > 0.0 ? y[i] : 0.0;
    d.log_odds[i] = 0.5 * (score * score / there - std::log(there));
    d.mean[i] = score / there;
    d.variance[i] = 1.0 / there;
  }
  return LU * second_moment(d) * LU.transpose();
}

}  // namespace magimu
