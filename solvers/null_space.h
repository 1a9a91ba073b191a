// SPDX-License-Identifier: BSD-3-Clause
// The directions in which the data say nothing: null vectors of the linearized graph. They are
// found and put into words, never divided by.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "solvers/linear/linear_solver.h"

namespace magimu {

struct NullDirection {
  double singular_value = 0.0;  // of the Jacobian with columns of unit norm
  VectorXd direction;           // d tangent, unit norm in those scaled columns, then unscaled
};

// A singular value of the column-scaled Jacobian below this is zero up to rounding.
inline constexpr double kNullTolerance = 1e-8;

// All null directions: singular values of the column-scaled Jacobian below tolerance, at most
// max_directions of them (a deficiency larger than that needs no longer list). By subspace
// iteration with the inverse of the damped normal matrix; the values themselves come from |J v|,
// which loses nothing to squaring.
std::vector<NullDirection> find_null_space(const LinearSystem& system, LinearSolver& solver,
                                           double tolerance = kNullTolerance,
                                           int max_directions = 8);

// Is there no such direction, nor one that rounding might take for it? solver: factorized undamped
// in scaled columns. A few steps of inverse iteration, far cheaper than the search; false where
// only that can tell.
bool is_regular(LinearSolver& solver, int columns);

// The direction in words: which variables move, the strongest first, many of one letter summed up
// ("x0 along (0.96), R0 to R99"). `name` puts one variable into the user's words.
std::string describe(
    const NullDirection& direction, const Values& values,
    const std::function<std::string(Key)>& name = [](Key key) { return to_string(key); });

// Several directions in words, equal ones once. Variables that all move alike, as a trajectory
// without a prior does, are said to: "R0 to R19 all by the same turn (3 free axes)".
std::string describe(const std::vector<NullDirection>& directions, const Values& values);

}  // namespace magimu
