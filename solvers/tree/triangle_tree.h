// SPDX-License-Identifier: BSD-3-Clause
// The condensed windows of one chain as the leaves of a balanced binary tree, whose inner vertices
// are the merges of their two children. To add a window, or to replace one, takes a number of
// merges that grows with the logarithm of the number of windows. The root is what the whole chain
// says about its last node and the globals. The nodes between windows are solved from the root
// downwards, and only those that somebody asks for.
//
// Old leaves can be put to sleep, in stretches of sixteen: they are packed, and the triangles
// between them and the stretch's own are dropped. Where a leaf of such a stretch changes, those are
// merged again on the way, fifteen merges instead of four. All results have the same bits.
#pragma once

#include <cstdint>
#include <vector>

#include "solvers/tree/condensed_triangle.h"
#include "solvers/tree/packed_triangle.h"

namespace magimu {

class TriangleTree {
 public:
  int size() const { return int(leaves_.size()); }

  // New contents take effect with the next refresh().
  void append(CondensedTriangle leaf);
  void replace(int leaf, CondensedTriangle with);
  CondensedTriangle leaf(int i) const;
  // |R delta|^2 of a leaf.
  double moved_squares(int leaf, const VectorXd& delta) const;
  // Merges what has changed; globals: their number by now. Returns the number of merges.
  int refresh(int globals);
  // Puts all stretches that end before leaf `end` to sleep. Call after refresh().
  void sleep(int end);

  const CondensedTriangle& root() const { return triangle(int(levels_.size()), 0); }
  // The root with another triangle in the place of one leaf. The tree does not change.
  CondensedTriangle root_with(int leaf, const CondensedTriangle& instead, int globals) const;

  // The solution at the root: coordinates of the chain's last node and of the globals.
  void set_solution(const VectorXd& last, const VectorXd& globals);
  // Coordinates of a leaf's last node.
  const VectorXd& last_of(int leaf) const;
  // How each leaf's last node follows the globals, all nodes at their best: d last / d globals.
  std::vector<MatrixXd> follow_globals(int globals) const;

 private:
  static constexpr int kStretchLevels = 4, kStretch = 1 << kStretchLevels;
  struct Leaf {
    CondensedTriangle triangle;  // or, asleep:
    PackedTriangle packed;
  };
  struct Vertex {
    CondensedTriangle triangle;  // empty within a stretch that sleeps
    EliminatedNode shared;
  };
  const CondensedTriangle& triangle(int level, int i) const;
  int count(int level) const;  // vertices at a level; the leaves are level 0
  bool asleep(int leaf) const { return leaf < asleep_; }
  CondensedTriangle remade(int level, int i, int globals);
  CondensedTriangle merged_with(int level, int i, int leaf, const CondensedTriangle& instead,
                                int globals) const;

  std::vector<Leaf> leaves_;
  std::vector<std::vector<Vertex>> levels_;  // level 1, 2, ...; one without a right child is empty
  std::vector<int> changed_;
  int asleep_ = 0;  // leaves before this one, whole stretches
  VectorXd globals_;
  std::uint64_t solution_ = 0;  // its number
  mutable std::vector<VectorXd> last_;
  mutable std::vector<std::uint64_t> solved_;  // the solution_ that each of last_ belongs to
};

}  // namespace magimu
