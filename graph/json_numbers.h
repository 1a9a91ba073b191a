// SPDX-License-Identifier: BSD-3-Clause
// Vectors and matrices in JSON: a vector as its numbers, a matrix as the list of its rows.
#pragma once

#include <Eigen/Core>

namespace magimu {

// Json: nlohmann's json or ordered_json.
template <class Json, class Derived>
Json json_numbers(const Eigen::MatrixBase<Derived>& of) {
  Json out = Json::array();
  for (Eigen::Index i = 0; i < of.rows(); ++i) {
    if constexpr (Derived::ColsAtCompileTime == 1) {
      out.push_back(of(i));
    } else {
      Json row = Json::array();
      for (Eigen::Index j = 0; j < of.cols(); ++j) row.push_back(of(i, j));
      out.push_back(std::move(row));
    }
  }
  return out;
}

}  // namespace magimu
