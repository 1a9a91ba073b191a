// SPDX-License-Identifier: BSD-3-Clause
// How each sample of one sensor changes with the parameters of the effects on it.
#pragma once

#include "graph/rot3.h"

namespace magimu {

struct EffectColumns {
  int parameters = 0;
  Eigen::Matrix<double, 3, Eigen::Dynamic> all;  // sample after sample, 3 x parameters each

  auto of(std::size_t sample) const {
    return all.middleCols(Eigen::Index(sample) * parameters, parameters);
  }
  auto of(std::size_t sample) {
    return all.middleCols(Eigen::Index(sample) * parameters, parameters);
  }
  // Mean over count samples from `first` on.
  Eigen::Matrix<double, 3, Eigen::Dynamic> mean(std::size_t first, int count) const {
    Eigen::Matrix<double, 3, Eigen::Dynamic> sum = of(first);
    for (int k = 1; k < count; ++k) sum += of(first + std::size_t(k));
    return sum / double(count);
  }
};

}  // namespace magimu
