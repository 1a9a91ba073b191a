// SPDX-License-Identifier: BSD-3-Clause
// Devices drawn for tests of changes: recordings measure a few correlated parameters, among them
// three of one group.
#pragma once

#include <random>

#include "archive/change_search.h"

namespace magimu::test {

struct DrawnDevice {
  ChangeProblem problem;
  MatrixXd sigma;  // covariance of the parameters as one recording tells them
};

// truth: the parameters at each recording, in units of one.
inline DrawnDevice draw_device(const std::vector<VectorXd>& truth, std::uint64_t seed,
                               Eigen::Index group = 3) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Eigen::Index n = truth.front().size();
  DrawnDevice out;
  MatrixXd mean = MatrixXd::Zero(n, n);
  std::vector<MatrixXd> all;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    // Parameters of unequal size and correlated, as a recording's motion has it.
    MatrixXd J(3 * n, n);
    for (double& x : J.reshaped()) x = normal(random);
    J.col(1) += J.col(0);
    J.col(n - 1) += 2.0 * J.col(1);
    all.push_back(J.transpose() * J);
    mean += all.back() / double(truth.size());
  }
  out.sigma = mean.inverse();
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const Eigen::LLT<MatrixXd> llt(all[k]);
    VectorXd e(n);
    for (double& x : e) x = normal(random);
    const VectorXd y = truth[k] + llt.matrixU().solve(e);
    out.problem.recordings.push_back({all[k], all[k] * y, 0.0});
    out.problem.time.push_back(double(k));
  }
  out.problem.prior = {1e-6 * MatrixXd::Identity(n, n), VectorXd::Zero(n), 0.0};
  for (Eigen::Index first = 0; first + group <= n; first += group) {
    MatrixXd G = MatrixXd::Zero(n, group);
    G.middleRows(first, group).setIdentity();
    out.problem.groups.push_back({"group " + std::to_string(first), "parameters", G,
                                  out.sigma.block(first, first, group, group)});
  }
  return out;
}

// `sigmas` of one recording along a direction of the first group.
inline VectorXd step_of(const DrawnDevice& device, double sigmas, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const VectorXd direction = Vector3(normal(random), normal(random), normal(random)).normalized();
  const MatrixXd W = device.sigma.topLeftCorner(3, 3);
  const double sigma = std::sqrt(direction.dot(W * direction));
  VectorXd out = VectorXd::Zero(device.sigma.rows());
  out.head<3>() = sigmas * sigma * direction;
  return out;
}

}  // namespace magimu::test
