// SPDX-License-Identifier: BSD-3-Clause
// The two steps in which the elimination of nodes with a wide border spends its time, compiled once
// for each instruction set (rank_update.inc). Rows of numbers are `width` long, a multiple of
// kWidthUnit, and start on 64 bytes.
#pragma once

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
};
RankCode rank_code(Isa isa);

}  // namespace magimu::lanes
