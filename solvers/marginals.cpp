// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/marginals.h"

#include <algorithm>

#include "graph/numerical_error.h"
#include "solvers/back_ends.h"
#include "solvers/damped_factor.h"

namespace magimu {
namespace {

// Directions left free. A gauge or a motion that lacks something leaves a few a chain; noise that
// is out of all proportion leaves thousands, and each costs as much as a solution.
constexpr int kMostFree = 128;

std::vector<int> columns_of(const Values& values, const std::vector<Key>& keys) {
  std::vector<int> columns;
  for (const Key key : keys) {
    const Values::Slot& slot = values.slot(key);
    for (int c = 0; c < slot.type.tangent(); ++c) columns.push_back(slot.tangent + c);
  }
  return columns;
}

LinearSystem linearized(const FactorGraph& graph, const Values& values) {
  LinearSystem system(graph, values);
  system.linearize(values);
  return system;
}

}  // namespace

Marginals::Marginals(const FactorGraph& graph, const Values& values, Backend backend)
    : Marginals(linearized(graph, values), values, backend) {}

Marginals::Marginals(const LinearSystem& system, const Values& values, Backend backend)
    : values_(values), scale_(column_scale(system)), solver_(make_linear_solver(backend)) {
  if (!is_finite(system)) {
    throw NumericalError("the linear system has numbers that are not finite");
  }
  if (solver_->factorize(system, scale_, 0.0) && is_regular(*solver_, system.cols())) return;
  find_null_space_of(system);
  // With directions left free, find_null_space's damped factor serves: they are projected out.
  // Otherwise next to no damping, where rounding asks for it: what it bounds is hardly determined,
  // and stays so by its standard deviation.
  if (!null_space_.empty()) return;
  for (double damping = 0.0; damping < 1e-9; damping = std::max(1e-16, 10.0 * damping)) {
    if (solver_->factorize(system, scale_, damping)) return;
  }
  throw NumericalError("the graph is too close to singular for its covariance");
}

void Marginals::find_null_space_of(const LinearSystem& system) {
  // All of them: one that is missed would pass for determined.
  for (int limit = 8;; limit *= 2) {
    null_space_ = find_null_space(system, *solver_, kNullTolerance, limit);
    if (int(null_space_.size()) < limit) break;
    if (limit >= kMostFree) {
      throw NumericalError("more than " + std::to_string(kMostFree) +
                           " combinations of variables are undetermined beside the others");
    }
  }
  null_basis_.resize(system.cols(), Eigen::Index(null_space_.size()));
  for (std::size_t i = 0; i < null_space_.size(); ++i) {
    null_basis_.col(Eigen::Index(i)) = null_space_[i].direction.cwiseQuotient(scale_);
  }
}

MatrixXd Marginals::covariance(const std::vector<Key>& keys) const {
  const std::vector<int> columns = columns_of(values_, keys);
  std::vector<NullDirection> free;
  for (Eigen::Index i = 0; i < null_basis_.cols(); ++i) {
    const bool moves =
        std::ranges::any_of(columns, [&](int c) { return std::abs(null_basis_(c, i)) > 1e-6; });
    if (moves) free.push_back(null_space_[std::size_t(i)]);
  }
  if (!free.empty()) {
    throw NumericalError("the data leave a combination undetermined: " + describe(free, values_));
  }
  return determined_covariance(keys);
}

MatrixXd Marginals::determined_columns(const std::vector<Key>& keys) const {
  const std::vector<int> columns = columns_of(values_, keys);
  const auto n = Eigen::Index(columns.size());
  MatrixXd unit = MatrixXd::Zero(scale_.size(), n);
  for (Eigen::Index i = 0; i < n; ++i) {
    unit(columns[std::size_t(i)], i) = scale_[columns[std::size_t(i)]];
  }
  if (!null_space_.empty()) unit -= null_basis_ * (null_basis_.transpose() * unit);
  MatrixXd X = solver_->solve_normal(unit);
  if (!null_space_.empty()) X -= null_basis_ * (null_basis_.transpose() * X);
  X.array().colwise() *= scale_.array();
  return X;
}

MatrixXd Marginals::covariance_in(const MatrixXd& columns, const std::vector<Key>& keys) const {
  const MatrixXd S = columns(columns_of(values_, keys), Eigen::all);
  return 0.5 * (S + S.transpose());
}

MatrixXd Marginals::determined_covariance(const std::vector<Key>& keys) const {
  return covariance_in(determined_columns(keys), keys);
}

}  // namespace magimu
