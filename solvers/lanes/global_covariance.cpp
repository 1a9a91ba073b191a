// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/global_covariance.h"

#include "solvers/lanes/window_engine.h"

namespace magimu {
namespace {

// As for an optimizer's steps (levenberg_marquardt.h): Cholesky keeps no digits below it.
constexpr double kLeastPivot = 1e-13;

}  // namespace

std::optional<MatrixXd> global_covariance(const FactorGraph& graph, const Values& values,
                                          const std::vector<Key>& keys) {
  const std::unique_ptr<WindowEngine> engine = WindowEngine::make(graph, values);
  if (!engine) return std::nullopt;
  std::vector<int> columns;
  for (const Key key : keys) {
    const Values::Slot& slot = values.slot(key);
    const auto place = static_cast<std::size_t>(&slot - values.slots().data());
    const lanes::Layout::Variable& variable = engine->layout().variables[place];
    if (variable.node >= 0) return std::nullopt;
    for (int c = 0; c < slot.type.tangent(); ++c) columns.push_back(variable.tangent + c);
  }
  engine->load(values);
  engine->condense(0.0);
  if (!engine->solve() || engine->smallest_pivot() < kLeastPivot) return std::nullopt;
  const MatrixXd all = engine->covariance_globals();
  return MatrixXd(all(columns, columns));
}

}  // namespace magimu
