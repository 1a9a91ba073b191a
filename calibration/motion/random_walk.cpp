// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/random_walk.h"

#include <cmath>

#include "graph/decompositions.h"
#include "statistics/tails.h"

namespace magimu {

RandomWalk estimate_random_walk(const MatrixXd& A, const VectorXd& z, const VectorXd& unit_sigma,
                                double excess) {
  const MatrixXd M = unit_sigma.asDiagonal() * A * unit_sigma.asDiagonal() / excess;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(M);
  const VectorXd m = eigen.eigenvalues().cwiseMax(0.0);
  const VectorXd w = eigen.eigenvectors().transpose() * (unit_sigma.asDiagonal() * z) / excess;
  const double tiny = 1e-12 * m.maxCoeff();
  const auto log_likelihood = [&](double q2) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < m.size(); ++i) {
      if (m[i] <= tiny) continue;
      const double growth = 1.0 + q2 * m[i];
      sum -= 0.5 * (std::log(growth) + w[i] * w[i] / (m[i] * growth));
    }
    return sum;
  };
  RandomWalk out;
  if (!(m.maxCoeff() > 0.0)) return out;
  const double none = log_likelihood(0.0);
  // q^2 m is of the order of the signal's power over the noise's.
  double best = none, at = 0.0;
  const double unit = 1.0 / m.maxCoeff();
  for (double e = -4.0; e <= 10.0; e += 0.02) {
    const double q2 = unit * std::pow(10.0, e), value = log_likelihood(q2);
    if (value > best) {
      best = value;
      at = q2;
    }
  }
  if (at == 0.0) return out;
  out.density = std::sqrt(at);
  out.likelihood_ratio = 2.0 * (best - none);
  out.log10_p = std::min(0.0, log10_chi_square_tail(out.likelihood_ratio, 1.0) + std::log10(0.5));
  // Curvature in log q.
  constexpr double kStep = 0.05;
  const double around = log_likelihood(at * std::exp(2.0 * kStep)) +
                        log_likelihood(at * std::exp(-2.0 * kStep)) - 2.0 * best;
  out.sigma = around < 0.0 ? out.density * kStep / std::sqrt(-around) : out.density;
  return out;
}

}  // namespace magimu
