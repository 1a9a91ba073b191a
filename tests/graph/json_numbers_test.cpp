// SPDX-License-Identifier: BSD-3-Clause
#include "graph/json_numbers.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "graph/scalar.h"

namespace magimu {
namespace {

TEST(JsonNumbers, of_a_vector_are_a_list_and_of_a_matrix_its_rows) {
  using nlohmann::json;
  EXPECT_EQ(json_numbers<json>(Vector3(1.0, 2.0, 3.0)), (json{1.0, 2.0, 3.0}));
  EXPECT_EQ(json_numbers<json>(VectorXd()), json::array());
  MatrixXd m(2, 3);
  m << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  EXPECT_EQ(json_numbers<json>(m), (json{{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}}));
}

}  // namespace
}  // namespace magimu
