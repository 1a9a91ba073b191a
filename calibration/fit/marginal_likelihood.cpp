// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/marginal_likelihood.h"

#include "calibration/model/windows.h"
#include "graph/decompositions.h"
#include "solvers/condensed/windows_on_demand.h"

namespace magimu {
namespace {

constexpr double kUndeterminedEigenvalue = 1e-12;  // an eigenvalue of what nothing determines

double log_det_whitening(const FactorGraph& graph) {
  double sum = 0.0;
  for (const auto& batch : graph.batches()) {
    for (int i = 0; i < batch->size(); ++i) sum += magimu::log_det_whitening(*batch, i);
  }
  return sum;
}

}  // namespace

double log_det_whitening(const FactorBatch& batch, int i) {
  if (batch.whitening(i) == nullptr) return 0.0;
  const int n = batch.rows();
  const Eigen::Map<const MatrixXd> W(batch.whitening(i), n, n);  // triangular
  return W.diagonal().array().log().sum();
}

double log_marginal_likelihood(const Stage& stage) {
  const Values& values = stage.result().values;
  const FactorTable factors(stage.graph(), values);
  const CondensedWindow all = condense(factors, values, node_of, windows_of(stage.plans())).whole();
  // Parameters have different units: eigenvalues of the information with a unit diagonal.
  const VectorXd diagonal = all.information.diagonal();
  const VectorXd unit = diagonal.cwiseSqrt().cwiseInverse();
  const VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(
          MatrixXd(unit.asDiagonal() * all.information * unit.asDiagonal()))
          .eigenvalues();
  const double log_det = all.log_det + diagonal.array().log().sum() +
                         eigenvalues.array().max(kUndeterminedEigenvalue).log().sum();
  return log_det_whitening(stage.graph()) - 0.5 * (2.0 * stage.result().cost_final + log_det);
}

}  // namespace magimu
