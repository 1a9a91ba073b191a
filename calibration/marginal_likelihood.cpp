// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/marginal_likelihood.h"

#include <Eigen/LU>
#include <cmath>

#include "calibration/windows.h"
#include "graph/decompositions.h"
#include "graph/linear_system.h"

namespace magimu {
namespace {

constexpr double kFlat = 1e-12;  // of the largest eigenvalue: a direction that nothing determines

double log_det_whitening(const FactorGraph& graph) {
  double sum = 0.0;
  for (const auto& batch : graph.batches()) {
    const int n = batch->rows();
    for (int i = 0; i < batch->size() && batch->whitening(i) != nullptr; ++i) {
      const Eigen::Map<const MatrixXd> W(batch->whitening(i), n, n);
      if (batch->whitening_is_diagonal()) {
        sum += W.diagonal().array().abs().log().sum();
      } else {
        sum += std::log(std::abs(W.determinant()));
      }
    }
  }
  return sum;
}

}  // namespace

double log_marginal_likelihood(const Stage& stage) {
  const Values& values = stage.result().values;
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const CondensedWindow all = condense(system, values, node_of, all_in_one(stage.plans())).sum();
  const VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(all.information).eigenvalues();
  const double floor = kFlat * eigenvalues.maxCoeff();
  const double log_det = all.log_det + eigenvalues.array().max(floor).log().sum();
  return log_det_whitening(stage.graph()) - 0.5 * (2.0 * stage.result().cost_final + log_det);
}

}  // namespace magimu
