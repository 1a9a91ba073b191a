// SPDX-License-Identifier: BSD-3-Clause
// A condensed triangle without the zeros left of its diagonal: half the memory, the same bits. Old
// windows of a long stream are kept in this form (triangle_tree.h).
#pragma once

#include <vector>

#include "graph/bytes.h"
#include "solvers/tree/condensed_triangle.h"

namespace magimu {

class PackedTriangle {
 public:
  PackedTriangle() = default;
  explicit PackedTriangle(const CondensedTriangle& triangle);

  bool empty() const { return numbers_.empty(); }
  CondensedTriangle unpacked() const;
  // |R delta|^2; delta: width() components.
  double moved_squares(const VectorXd& delta) const;

  void save(ByteWriter& out) const;
  void load(ByteReader& in);

 private:
  int last_ = 0, first_ = 0, globals_ = 0;
  double squares_ = 0.0;
  std::vector<double> numbers_;  // row by row from the diagonal on, the column d included
};

// The same of a triangle as it is.
double moved_squares(const CondensedTriangle& triangle, const VectorXd& delta);

}  // namespace magimu
