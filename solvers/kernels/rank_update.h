// SPDX-License-Identifier: BSD-3-Clause
// The steps in which eliminations spend their time, compiled once for each instruction set
// (rank_update.inc): two of nodes with a wide border, whose rows of numbers are `width` long, a
// multiple of kWidthUnit, and start on 64 bytes; and Householder's (reflections.inc).
#pragma once

#include <cstddef>

#include "graph/lanes.h"

namespace magimu::lanes {

inline constexpr int kWidthUnit = 8;
constexpr int padded(int width) { return (width + kWidthUnit - 1) / kWidthUnit * kWidthUnit; }

struct RankCode {
  // square += sign rows' rows, of `count` rows; the upper triangle, and some of the lower.
  void (*update)(const double* rows, int count, int width, double sign, double* square);
  // With U = [U1 | U2], its rows `stride` apart, U1 upper triangular and n x n, U2 n x rest, and
  // `inverse` that of U1's diagonal:
  //   the first n rows x <- U1'^-1 x, the rest that follow y <- y - U2' x
  void (*eliminate)(const double* U, int stride, const double* inverse, int n, int rest,
                    double* rows, int width);
  // Householder reflections of the rows from `top` on, as householder.h describes them. Rows are
  // `stride` doubles apart, a multiple of kWidthUnit that begins on 64 bytes; left of column
  // `begin` they are zero. numbers: room for 2 (stride + rows), on 64 bytes; integers: for end -
  // begin + 3 rows.
  int (*triangularize)(double* A, std::ptrdiff_t stride, int rows, int top, int begin, int end,
                       int* pivot_row, double* numbers, int* integers);
};
RankCode rank_code(Isa isa);

}  // namespace magimu::lanes
