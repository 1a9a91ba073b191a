// SPDX-License-Identifier: BSD-3-Clause
// How each sample of one sensor changes with the parameters of the effects on it. Those of all
// samples take more memory than all the rest, so they are found when they are asked for: whoever
// takes means or integrates sees each of them once.
#pragma once

#include <functional>

#include "graph/rot3.h"

namespace magimu {

struct EffectColumns {
  using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic>;

  int parameters = 0;
  std::function<void(std::size_t sample, Columns& out)> write;  // out: 3 x parameters

  Columns of(std::size_t sample) const {
    Columns out(3, parameters);
    if (parameters > 0) write(sample, out);
    return out;
  }
  // Mean over count samples from `first` on.
  Columns mean(std::size_t first, int count) const {
    Columns sum = of(first), next(3, parameters);
    for (int k = 1; k < count; ++k) {
      write(first + std::size_t(k), next);
      sum += next;
    }
    return sum / double(count);
  }
};

// The columns of one sample after another; null: none.
class SampleColumns {
 public:
  explicit SampleColumns(const EffectColumns* all)
      : all_(all), own_(3, all == nullptr ? 0 : all->parameters) {}

  const EffectColumns::Columns& of(std::size_t sample) {
    if (own_.cols() > 0 && sample != sample_) all_->write(sample, own_);
    sample_ = sample;
    return own_;
  }

 private:
  const EffectColumns* all_;
  EffectColumns::Columns own_;
  std::size_t sample_ = std::size_t(-1);
};

}  // namespace magimu
