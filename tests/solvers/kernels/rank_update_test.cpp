// SPDX-License-Identifier: BSD-3-Clause
// The kernels of every instruction set that this machine has, against Eigen.
#include "solvers/kernels/rank_update.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

#include "solvers/kernels/aligned_buffer.h"

namespace magimu {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

AlignedBuffer aligned(const Rows& rows) {
  AlignedBuffer out{std::size_t(rows.size())};
  std::copy_n(rows.data(), rows.size(), out.data());
  return out;
}

class RankUpdate : public testing::TestWithParam<Isa> {
 protected:
  void SetUp() override {
    if (!is_available(GetParam())) GTEST_SKIP();
  }
};

TEST_P(RankUpdate, adds_products_of_rows) {
  for (const int width : {8, 24, 40, 96}) {
    const Rows R = Rows::Random(13, width), C = Rows::Random(width, width);
    const AlignedBuffer rows = aligned(R);
    AlignedBuffer square = aligned(C);
    lanes::rank_code(GetParam()).update(rows.data(), 13, width, -1.0, square.data());
    const Rows expected = C - R.transpose() * R;
    const Eigen::Map<const Rows> found(square.data(), width, width);
    EXPECT_LT(Rows((found - expected).triangularView<Eigen::Upper>()).norm(), 1e-13 * width);
  }
}

TEST_P(RankUpdate, eliminates_the_first_rows) {
  constexpr int kFirst = 3, kRest = 9, kWidth = 40;
  Rows U = Rows::Random(kFirst, kFirst + kRest);
  U.diagonal().array() += 3.0;
  const Rows R = Rows::Random(kFirst + kRest, kWidth);
  AlignedBuffer rows = aligned(R);
  const Eigen::VectorXd inverse = U.diagonal().cwiseInverse();
  lanes::rank_code(GetParam())
      .eliminate(U.data(), kFirst + kRest, inverse.data(), kFirst, kRest, rows.data(), kWidth);
  const Eigen::Map<const Rows> found(rows.data(), kFirst + kRest, kWidth);
  const Rows first =
      U.leftCols(kFirst).triangularView<Eigen::Upper>().transpose().solve(R.topRows(kFirst));
  EXPECT_LT((found.topRows(kFirst) - first).norm(), 1e-13);
  const Rows rest = R.bottomRows(kRest) - U.rightCols(kRest).transpose() * first;
  EXPECT_LT((found.bottomRows(kRest) - rest).norm(), 1e-12);
}

// Two triangles on different columns, stacked, and rows full of numbers: R'R stays what it was.
TEST_P(RankUpdate, triangularizes_stacked_rows) {
  constexpr int kTop = 2, kBegin = 3;
  for (const int columns : {13, 29, 47, 111}) {
    const int stride = lanes::padded(columns), n = columns - kBegin - 1, rows = kTop + 2 * n + 2;
    Rows A = Rows::Zero(rows, stride);
    A.topLeftCorner(kTop, columns).setRandom();  // above the top: not to be touched
    Rows triangle = Rows::Random(n, n + 1).triangularView<Eigen::Upper>();
    A.block(kTop, kBegin, n, n + 1) = triangle;
    A.block(kTop + n, kBegin, n, n + 1) = triangle.reverse().triangularView<Eigen::Upper>();
    A.block(kTop + n, kBegin + 2, n, 1).setZero();
    A.block(kTop + 2 * n, kBegin, 2, n + 1).setRandom();
    A.col(kBegin + 4).tail(rows - kTop).setZero();
    AlignedBuffer numbers = aligned(A);
    AlignedBuffer work{std::size_t(2 * (stride + rows))};
    std::vector<int> pivots(std::size_t(n), -2), integers(std::size_t(n + 3 * rows), 0);
    const int below = lanes::rank_code(GetParam())
                          .triangularize(numbers.data(), stride, rows, kTop, kBegin, kBegin + n,
                                         pivots.data(), work.data(), integers.data());
    const Eigen::Map<const Rows> found(numbers.data(), rows, stride);
    EXPECT_EQ(below, kTop + n - 1) << "one column is zero";
    EXPECT_EQ(found.topRows(kTop), A.topRows(kTop));
    int next = kTop;
    for (int j = 0; j < n; ++j) {
      EXPECT_EQ(pivots[std::size_t(j)], j == 4 ? -1 : next) << j;
      if (j != 4) ++next;
      EXPECT_EQ(found.col(kBegin + j).tail(rows - next).cwiseAbs().maxCoeff(), 0.0) << j;
    }
    const Rows before = A.bottomRows(rows - kTop), after = found.bottomRows(rows - kTop);
    EXPECT_LT((after.transpose() * after - before.transpose() * before).norm(),
              1e-13 * before.squaredNorm())
        << columns;
  }
}

TEST_P(RankUpdate, triangularizes_rows_that_begin_in_any_order) {
  constexpr int kColumns = 20, kStride = 24, kRows = 16;
  Rows A = Rows::Zero(kRows, kStride);
  for (int i = 0; i < kRows; ++i) {
    const int first = (7 * i + 5) % 17;
    A.block(i, first, 1, kColumns - first).setRandom();
  }
  AlignedBuffer numbers = aligned(A), work{std::size_t(2 * (kStride + kRows))};
  std::vector<int> pivots(kColumns - 1), integers(kColumns + 3 * kRows);
  const int below = lanes::rank_code(GetParam())
                        .triangularize(numbers.data(), kStride, kRows, 0, 0, kColumns - 1,
                                       pivots.data(), work.data(), integers.data());
  const Eigen::Map<const Rows> found(numbers.data(), kRows, kStride);
  EXPECT_EQ(below, kRows);
  for (int i = 0; i < kRows; ++i) {
    for (int j = 0; j < kColumns - 1; ++j) {
      if (pivots[std::size_t(j)] == i) break;
      EXPECT_EQ(found(i, j), 0.0) << i << " " << j;
    }
  }
  EXPECT_LT((found.transpose() * found - A.transpose() * A).norm(), 1e-13 * A.squaredNorm());
}

INSTANTIATE_TEST_SUITE_P(Of, RankUpdate, testing::Values(Isa::kBaseline, Isa::kAvx2, Isa::kAvx512),
                         [](const auto& i) {
                           return i.param == Isa::kAvx512 ? "avx512" : to_string(i.param);
                         });

}  // namespace
}  // namespace magimu
