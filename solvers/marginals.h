// SPDX-License-Identifier: BSD-3-Clause
// How sure the optimum is: covariance of any variables, all others integrated out, from the
// linearized graph (the inverse of J'J). The tangent of a rotation is the left one.
//
//   const Marginals marginals(graph, result.values);
//   const MatrixXd S = marginals.covariance({key::mag_bias, key::dip});
#pragma once

#include <vector>

#include "solvers/null_space.h"

namespace magimu {

class Marginals {
 public:
  Marginals(const FactorGraph& graph, const Values& values, Backend backend = Backend::kAuto);
  // Of a system that was linearized at these values.
  Marginals(const LinearSystem& system, const Values& values, Backend backend = Backend::kAuto);

  // Joint covariance of some variables, in the order given, in their tangent coordinates.
  // Throws std::domain_error, with the direction in words, if one of them is undetermined.
  MatrixXd covariance(const std::vector<Key>& keys) const;
  MatrixXd covariance(Key key) const { return covariance(std::vector<Key>{key}); }

  // The same along every determined direction; undetermined ones count as known exactly.
  MatrixXd determined_covariance(const std::vector<Key>& keys) const;

  // The columns of the inverse of J'J that belong to these variables, with all rows (undetermined
  // directions as above). covariance_in: the variables' own rows of such columns, the covariance.
  MatrixXd determined_columns(const std::vector<Key>& keys) const;
  MatrixXd covariance_in(const MatrixXd& columns, const std::vector<Key>& keys) const;

  // What the data leave free; empty if all is determined.
  const std::vector<NullDirection>& null_space() const { return null_space_; }

  // By what all this was solved, factorized in columns scaled by that.
  LinearSolver& solver() const { return *solver_; }
  const VectorXd& scale() const { return scale_; }

 private:
  void find_null_space_of(const LinearSystem& system);

  Values values_;
  VectorXd scale_;
  std::unique_ptr<LinearSolver> solver_;
  std::vector<NullDirection> null_space_;
  MatrixXd null_basis_;  // orthonormal, in columns of unit norm
};

}  // namespace magimu
