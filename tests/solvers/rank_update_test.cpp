// SPDX-License-Identifier: BSD-3-Clause
// The kernels of every instruction set that this machine has, against Eigen.
#include "solvers/rank_update.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

#include "solvers/aligned_buffer.h"

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

TEST_P(RankUpdate, reflects_the_listed_rows) {
  const std::vector<int> list{6, 0, 3};
  const Eigen::Vector3d v(0.5, -1.0, 2.0);
  const double beta = 2.0 / v.squaredNorm();
  for (const int width : {8, 16, 40, 72}) {
    // Not on 64 bytes, and with columns to both sides that are not to be touched.
    Rows A = Rows::Random(8, width + 5);
    Rows expected = A;
    Rows listed = A(list, Eigen::seqN(3, width));
    listed -= beta * v * (v.transpose() * listed).eval();
    expected(list, Eigen::seqN(3, width)) = listed;
    lanes::rank_code(GetParam())
        .reflect(A.data() + 3, A.outerStride(), list.data(), 3, v.data(), beta, width);
    EXPECT_LT((A - expected).cwiseAbs().maxCoeff(), 1e-14) << width;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, RankUpdate, testing::Values(Isa::kBaseline, Isa::kAvx2, Isa::kAvx512),
                         [](const auto& i) {
                           return i.param == Isa::kAvx512 ? "avx512" : to_string(i.param);
                         });

}  // namespace
}  // namespace magimu
