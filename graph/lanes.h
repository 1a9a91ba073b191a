// SPDX-License-Identifier: BSD-3-Clause
// Work on several factors of one type at once, one in each lane of a SIMD register: the scalar of a
// factor's text is then a pack of doubles (pack.h). Code for each instruction set is compiled apart
// and chosen at run time. Numbers for lanes lie interleaved: entry i of lane k at i * lanes + k.
#pragma once

namespace magimu {

// Instruction sets that code is compiled for. kBaseline: what every machine of the architecture
// has.
enum class Isa { kBaseline, kAvx2, kAvx512 };

const char* to_string(Isa isa);
// Doubles in a register: 2, 4, 8.
constexpr int lanes_of(Isa isa) { return isa == Isa::kAvx512 ? 8 : isa == Isa::kAvx2 ? 4 : 2; }
// What this machine can run and what was compiled in.
bool is_available(Isa isa);
Isa best_isa();

// A factor type's residual and Jacobians, not whitened, in all lanes of an instruction set.
struct LaneText {
  // text: what was measured, `doubles` numbers a lane; x: one pointer a variable. Row i of the
  // Jacobian starts at J + i * stride * lanes; its last of stride entries is the residual.
  using Linearize = void(const double* text, const double* const* x, double* J, int stride);
  Linearize* linearize = nullptr;  // null: there is none
  int doubles = 0;

  // Products of the columns of [J | r], those that are not always zero: the one of columns
  // i <= j, with the rows' squared weights, is added to sums[to[product_index(i, j, columns)]].
  // weights: one a row, or null where the rows are whitened already, which may have mixed them.
  using AddProducts = void(const double* J, int stride, const double* weights, const int* to,
                           double* sums);
  AddProducts* add_products = nullptr;  // null: there is none
};

// Products of `columns` columns, each with itself and those after it, row by row.
constexpr int product_index(int i, int j, int columns) {
  return i * columns - i * (i - 1) / 2 + j - i;
}

// True for factors that have lane code: lane_text<F> is then defined in lane_texts_*.cpp, and
// F::Text<S> is the factor's text with measurements of the scalar S and nothing else in memory.
template <class F>
inline constexpr bool kHasLanes = false;
template <class F>
LaneText lane_text(Isa isa);

}  // namespace magimu
