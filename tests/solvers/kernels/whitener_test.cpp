// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/kernels/whitener.h"

#include <gtest/gtest.h>

namespace magimu {
namespace {

TEST(Whitener, whitens_what_is_determined_whatever_the_units) {
  MatrixXd J(4, 3);  // the third parameter repeats the first, in another unit
  J << 1.0, 0.2, 1e4, -0.5, 1.0, -0.5e4, 2.0, 0.1, 2e4, 0.3, -1.0, 0.3e4;
  const MatrixXd A = J.transpose() * J;
  const MatrixXd P = whitener(A, 1e-9);
  ASSERT_EQ(P.cols(), 2);
  EXPECT_LT((P.transpose() * A * P - MatrixXd::Identity(2, 2)).norm(), 1e-9);
}

TEST(Whitener, has_no_column_where_nothing_is_determined) {
  EXPECT_EQ(whitener(MatrixXd::Zero(3, 3), 1e-9).cols(), 0);
  EXPECT_EQ(whitener(MatrixXd(0, 0), 1e-9).cols(), 0);
}

}  // namespace
}  // namespace magimu
