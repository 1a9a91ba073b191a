// SPDX-License-Identifier: BSD-3-Clause
// Doubles that start on the boundary SIMD registers ask for, zero at first unless asked otherwise.
// Where there are many, the system is asked for large pages: thousands of small ones, touched for
// the first time, take longer than a pass over them.
#pragma once

#include <sys/mman.h>

#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

namespace magimu {

class AlignedBuffer {
 public:
  AlignedBuffer() = default;
  enum class Fill { kZero, kNone };
  explicit AlignedBuffer(std::size_t size, Fill fill = Fill::kZero) : size_(size) {
    constexpr std::size_t kAlignment = 64, kLargePage = std::size_t(1) << 21;
    std::size_t bytes = size * sizeof(double), alignment = kAlignment;
    if (bytes >= 2 * kLargePage) alignment = kLargePage;
    bytes = (bytes / alignment + 1) * alignment;
    data_.reset(static_cast<double*>(std::aligned_alloc(alignment, bytes)));
    if (!data_) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE  // only an advice: without it the buffer is slower, not wrong
    if (alignment == kLargePage) madvise(data_.get(), bytes, MADV_HUGEPAGE);
#endif
    if (fill == Fill::kZero) std::memset(data_.get(), 0, bytes);
  }
  double* data() { return data_.get(); }
  const double* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  double& operator[](std::size_t i) { return data_[i]; }
  double operator[](std::size_t i) const { return data_[i]; }

 private:
  struct Free {
    void operator()(double* p) const { std::free(p); }
  };
  std::unique_ptr<double[], Free> data_;
  std::size_t size_ = 0;
};

}  // namespace magimu
