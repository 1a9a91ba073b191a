// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/tree/stretch.h"

#include "solvers/tree/packed_triangle.h"

namespace magimu {

void Stretch::save(ByteWriter& out) const {
  for (const CondensedTriangle* t : {&before, &others, &own}) PackedTriangle(*t).save(out);
}

void Stretch::load(ByteReader& in) {
  for (CondensedTriangle* t : {&before, &others, &own}) {
    PackedTriangle packed;
    packed.load(in);
    *t = packed.unpacked();
  }
}

Stretch joined(const Stretch& first, const Stretch& second) {
  return {first.before, first.others,
          merge(first.own, second.own, std::max(first.own.globals, second.own.globals), nullptr)};
}

// The stretch's triangle has the difference beside the globals, with the same columns; its last
// node is in no other row and is left out.
BlockScore difference(const Stretch& stretch, const std::vector<GlobalColumns>& columns) {
  const CondensedTriangle &before = stretch.before, &own = stretch.own;
  const int eliminated = before.last + own.globals, linked = own.first + own.globals;
  int wanted = 0;
  for (const GlobalColumns& c : columns) wanted += c.width;
  // [node between | globals | difference | d]
  RowStack A(before.width() + linked + stretch.others.globals, eliminated + wanted + 1);
  auto to = A.view();
  const Eigen::Index d = to.cols() - 1;
  const auto put = [&](int row, int column, const CondensedTriangle& t, int begin, int width) {
    const int rows = t.width() - begin;
    to.block(row, column, rows, width) = t.R.block(begin, begin, rows, width);
    to.col(d).segment(row, rows) = t.R.col(t.width()).segment(begin, rows);
  };
  put(0, 0, before, 0, before.width());
  put(before.width(), 0, own, own.last, linked);
  if (stretch.others.globals > 0) {
    put(before.width() + linked, before.last, stretch.others, 0, stretch.others.globals);
  }
  int column = eliminated;
  for (const GlobalColumns& c : columns) {
    to.block(before.width(), column, linked, c.width) =
        own.R.block(own.last, own.last + own.first + c.offset, linked, c.width);
    column += c.width;
  }
  std::vector<int> pivots;
  const int below = triangularize(A, 0, 0, eliminated, pivots);
  const int end = triangularize(A, below, eliminated, eliminated + wanted, pivots);
  const auto J = to.block(below, eliminated, end - below, wanted);
  return {J.transpose() * to.col(d).segment(below, end - below), J.transpose() * J};
}

}  // namespace magimu
