// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/kernels/square_sum.h"

#include <algorithm>

namespace magimu {
namespace {

constexpr int kTogether = 64;

std::size_t numbers(int rows, int width) { return std::size_t(rows) * std::size_t(width); }

}  // namespace

SquareSum::SquareSum(int columns)
    : code_(lanes::rank_code(best_isa())),
      columns_(columns),
      width_(lanes::padded(columns)),
      square_(numbers(width_, width_)) {}

void SquareSum::clear() {
  std::fill_n(square_.data(), square_.size(), 0.0);
  filled_ = 0;
}

double* SquareSum::rows(int count) {
  if (filled_ + count > kTogether) finish();
  if (rows_.size() < numbers(filled_ + count, width_)) {
    rows_ = AlignedBuffer(numbers(std::max(count, kTogether), width_), AlignedBuffer::Fill::kNone);
  }
  double* const out = rows_.data() + numbers(filled_, width_);
  std::fill_n(out, numbers(count, width_), 0.0);
  filled_ += count;
  return out;
}

void SquareSum::subtract(const double* rows, int count) {
  code_.update(rows, count, width_, -1.0, square_.data());
}

void SquareSum::finish() {
  if (filled_ > 0) code_.update(rows_.data(), filled_, width_, 1.0, square_.data());
  filled_ = 0;
}

}  // namespace magimu
