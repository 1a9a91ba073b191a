// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held/laplace_nll.h"

#include <cmath>

#include "calibration/model/windows.h"
#include "diagnosis/held/log_noise.h"
#include "graph/decompositions.h"

namespace magimu {
namespace {

double log_det(const MatrixXd& A) { return A.ldlt().vectorD().array().max(1e-300).log().sum(); }

}  // namespace

double laplace_nll(const Stage& stage, const std::vector<Integrated>& integrated) {
  const Values& values = stage.result().values;
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const CondensedChain chain = condense(system, values, node_of, windows_of(stage.plans()));
  const CondensedWindow& data = chain.linked;
  const std::vector<int> together(windows_of(stage.plans()).size(), 0);
  double nll = log_noise(stage, system, together).front() + 0.5 * (data.squares + data.log_det);

  // What the data and the prior say about parameters that are integrated, in units of the prior.
  std::vector<Eigen::Index> at;
  std::vector<double> sigma;
  for (const Integrated& p : integrated) {
    const Values::Slot& slot = values.slot(p.key);
    const Eigen::Map<const VectorXd> now(values.data().data() + slot.stored, p.mean.size());
    nll += 0.5 * (now - p.mean).cwiseQuotient(p.sigma).squaredNorm();
    for (Eigen::Index i = 0; i < p.mean.size(); ++i) {
      at.push_back(chain.position(values, p.key) + i);
      sigma.push_back(p.sigma[i]);
    }
  }
  if (at.empty()) return nll;
  const Eigen::Map<const VectorXd> unit(sigma.data(), Eigen::Index(sigma.size()));
  MatrixXd A = unit.asDiagonal() * data.information(at, at) * unit.asDiagonal();
  A.diagonal().array() += 1.0;
  return nll + 0.5 * log_det(A);
}

}  // namespace magimu
