// SPDX-License-Identifier: BSD-3-Clause
// What a stretch of a chain says, in square-root form: all nodes but the first and the last are
// eliminated, and what remains is
//
//   min over the inner nodes of |J x + r|^2 = |R (last, first, globals) + d|^2 + squares
//
// with R upper triangular (rows of directions about which the stretch says nothing are zero). Two
// stretches that share a node merge into one, at a cost that does not depend on their lengths. All
// unknowns are coordinates about anchors that are the same for everyone who uses them
// (incremental_qr.h).
#pragma once

#include "solvers/kernels/householder.h"

namespace magimu {

struct CondensedTriangle {
  int last = 0, first = 0, globals = 0;  // their widths; first: 0 where the chain starts here
  RowBlock R;                            // [last | first | globals | d]
  double squares = 0.0;

  int width() const { return last + first + globals; }
};

// A node that has been eliminated, in terms of those that it was coupled to: [node | last | first |
// globals | d], one row a degree of freedom.
struct EliminatedNode {
  int width = 0, last = 0, first = 0, globals = 0;
  RowBlock R;

  // The node's coordinates given those of the others (globals: as many as there were at the time,
  // or more). Directions about which nothing is known do not move.
  VectorXd solve(const VectorXd& last_x, const VectorXd& first_x, const VectorXd& globals_x) const;
};

// Merges two stretches and eliminates their shared node (left's last, right's first). `globals`:
// their number by now. `shared`, unless null, receives the eliminated node's rows.
CondensedTriangle merge(const CondensedTriangle& left, const CondensedTriangle& right, int globals,
                        EliminatedNode* shared);

// What the chain says about the globals alone: without its last node. The chain has no first.
CondensedTriangle without_last(const CondensedTriangle& chain);
// The sum of two triangles on globals alone.
CondensedTriangle sum(const CondensedTriangle& a, const CondensedTriangle& b, int globals);

// x with R x + d = 0 as nearly as possible; where R is singular (to `tolerance`, columns of unit
// norm) the shortest such x in those scaled columns.
VectorXd solve(const CondensedTriangle& globals, double tolerance);

// Solves the upper triangular T x = -b by substitution; components with a zero pivot stay 0.
VectorXd substitute(const Eigen::Ref<const RowBlock>& T, VectorXd b);

}  // namespace magimu
