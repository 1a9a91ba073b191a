// SPDX-License-Identifier: BSD-3-Clause
// The form that the chain back end needs, found from a system's structure alone: variables in
// levels of which each is coupled only to the next, and a few globals that all may share. It does
// not depend on the system's numbers, so it is found once (with the place of each product of a
// factor's columns) and serves all factorizations.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "graph/linear_system.h"

namespace magimu::chain {

struct Level {
  int first = 0, width = 0;  // its positions in the order of elimination
  int parent = -1;           // the level to which it is coupled among those eliminated later
  int parent_width = 0;
  std::size_t panel = 0;  // where its rows [U | W] of width + parent_width columns start
  int factor_begin = 0, factor_end = 0;
};

// Levels that are eliminated one after another; the last is coupled to level `root`, if any.
struct Range {
  int begin, end, root;
};

// Where a product of two groups of a factor's columns goes.
enum class Into { kOwn, kOwnBorder, kParent, kParentBorder };
struct Product {
  int a, na, b, nb;
  Into into;
  int row, col;
};
// The products of factors whose columns have the same places relative to their level.
struct Shape {
  int rows, columns;
  std::vector<Product> products;
};
struct ChainFactor {
  int first_entry, shape;
};

// Successive factors with the same globals; those are among the local columns first to
// first + global.size(); -1 for the others.
struct Run {
  int first_entry, rows, columns, first;
  std::vector<int> global;
};

struct Structure {
  int chain = 0, globals = 0;
  // Columns have unit norm, so this is zero up to rounding, which adds up along a chain: a singular
  // one of n columns passes with a pivot of about 1e-17 n.
  double min_pivot = 1e-14;
  std::vector<int> position;  // of a column: chain in the order of elimination, then globals
  std::vector<Level> levels;
  std::vector<Range> branches, trunks;  // all branches first, then the trunks they lead to
  std::size_t panels = 0;
  std::vector<ChainFactor> factors;  // by level
  std::vector<Shape> shapes;
  std::vector<Run> runs;
};

// Null where the system is not of this form: a level is wider than 40 columns, or there are more
// than 512 global columns.
std::optional<Structure> find_structure(const LinearSystem& system);

}  // namespace magimu::chain
