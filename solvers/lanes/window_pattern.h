// SPDX-License-Identifier: BSD-3-Clause
// Factors of one type whose columns lie alike, with what the lanes' code has to know of them.
#pragma once

#include <vector>

#include "solvers/kernels/aligned_buffer.h"
#include "solvers/lanes/window_layout.h"

namespace magimu::lanes {

struct OwnPattern {
  // code: place + 4 * offset of each key; slots: of one of the factors' variables.
  OwnPattern(const FactorBatch& factors, const NoiseKinds& noise, std::vector<int> code,
             const int* slots, const Layout& layout, Isa isa);
  OwnPattern(const OwnPattern&) = delete;
  OwnPattern& operator=(const OwnPattern&) = delete;

  // Numbers of factors, one in each lane (Call::data).
  void copy(std::span<const int> chosen, double* data) const;

  const FactorBatch& factors;
  std::vector<int> code;
  Pattern pattern{};

 private:
  // The rows of a factor in one lane, the residual last.
  static void linearize(const Pattern& p, int factor, int lane, int lanes, const double* const* x,
                        double* J);

  int lanes_;
  std::vector<Source> sources_;
  std::vector<int> places_;
  std::vector<Products> products_;
  std::vector<int> sums_;
  std::vector<int> globals_;
  AlignedBuffer whitening_;
  // For factors without lane code: stored numbers of each variable; and where they lie when the
  // variables of one factor stand side by side, the same for all.
  std::vector<int> sizes_;
  ResolvedKeys keys_;
};

}  // namespace magimu::lanes
