// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/chain/chain_elimination.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include "graph/parallel.h"

namespace magimu::chain {
namespace {

constexpr int kStrip = 96;  // rows of a long product that are taken at a time

using Pair = double __attribute__((vector_size(16)));

// C += sign * A'B for an I x (J vectors) block of C; all row-major.
template <class V, int I, int J>
inline void add_block(int rows, const double* a, int lda, const double* b, int ldb, double* c,
                      int ldc, double sign) {
  constexpr int kLanes = std::is_same_v<V, Pair> ? 2 : 1;
  V sum[I][J] = {};
  for (int k = 0; k < rows; ++k, a += lda, b += ldb) {
    V bk[J];
    std::memcpy(bk, b, sizeof bk);
    for (int i = 0; i < I; ++i) {
      for (int j = 0; j < J; ++j) sum[i][j] += a[i] * bk[j];
    }
  }
  for (int i = 0; i < I; ++i, c += ldc) {
    for (int j = 0; j < J; ++j) {
      V cij;
      std::memcpy(&cij, c + j * kLanes, sizeof cij);
      cij += sign * sum[i][j];
      std::memcpy(c + j * kLanes, &cij, sizeof cij);
    }
  }
}

template <int I>
inline void add_strip(int rows, const double* a, int lda, const double* b, int nb, int ldb,
                      double* c, int ldc, double sign) {
  int j = 0;
  for (; j + 4 <= nb; j += 4) add_block<Pair, I, 2>(rows, a, lda, b + j, ldb, c + j, ldc, sign);
  if (j + 2 <= nb) {
    add_block<Pair, I, 1>(rows, a, lda, b + j, ldb, c + j, ldc, sign);
    j += 2;
  }
  if (j < nb) add_block<double, I, 1>(rows, a, lda, b + j, ldb, c + j, ldc, sign);
}

// C += sign * A'B, A of rows x na, B of rows x nb; with `upper`, at least C's upper triangle.
void add_product(int rows, const double* a, int na, int lda, const double* b, int nb, int ldb,
                 double* c, int ldc, double sign, bool upper = false) {
  for (int i = 0; i < na;) {
    const int left = na - i, first = upper ? i : 0;
    const auto strip = [&](auto width) {
      add_strip<width()>(rows, a + i, lda, b + first, nb - first, ldb, c + i * ldc + first, ldc,
                         sign);
      i += width();
    };
    if (left >= 4 && left % 3 != 0) {
      strip(std::integral_constant<int, 4>{});
    } else if (left >= 3) {
      strip(std::integral_constant<int, 3>{});
    } else if (left == 2) {
      strip(std::integral_constant<int, 2>{});
    } else {
      strip(std::integral_constant<int, 1>{});
    }
  }
}

// C += sign * A'A (upper triangle) for a tall A.
void add_square(int rows, const double* a, int n, int lda, double* c, int ldc, double sign) {
  for (int k = 0; k < rows; k += kStrip) {
    const double* ak = a + std::ptrdiff_t(k) * lda;
    add_product(std::min(kStrip, rows - k), ak, n, lda, ak, n, lda, c, ldc, sign, true);
  }
}

// x *= s; y -= s x.
inline void scale_row(double* x, int n, double s) {
  for (int j = 0; j < n; ++j) x[j] *= s;
}
inline void subtract_row(double* y, const double* x, int n, double s) {
  for (int j = 0; j < n; ++j) y[j] -= s * x[j];
}

}  // namespace

// The globals' own block becomes U, by rows.
bool Elimination::eliminate_center(Pivots& pivots) {
  const int g = s_.globals;
  double* const inverse_diagonal = inverse_diagonal_.data() + s_.chain;
  for (int i = 0; i < g; ++i) {
    double* const row = center_.data() + std::ptrdiff_t(i) * g;
    if (!pivots.add(row[i])) return false;
    inverse_diagonal[i] = 1.0 / std::sqrt(row[i]);
    scale_row(row + i, g - i, inverse_diagonal[i]);
    for (int k = i + 1; k < g; ++k) {
      subtract_row(center_.data() + std::ptrdiff_t(k) * g + k, row + k, g - k, row[k]);
    }
  }
  return true;
}

Elimination::Elimination(Structure structure) : s_(std::move(structure)) {
  panels_.resize(s_.panels);
  border_.resize(std::size_t(s_.chain) * std::size_t(s_.globals));
  inverse_diagonal_.resize(s_.position.size());
  center_.resize(std::size_t(s_.globals) * std::size_t(s_.globals));
  std::size_t jacobian = 0;
  for (const Shape& shape : s_.shapes) {
    jacobian = std::max(jacobian, std::size_t(shape.rows) * std::size_t(shape.columns));
  }
  int widest = 0;
  for (const Level& level : s_.levels) widest = std::max(widest, level.width);
  for (std::size_t i = 0; i <= s_.branches.size(); ++i) {
    work_.push_back({BorderedChain(s_.globals, widest, 0.0),
                     std::vector<double>(jacobian),
                     {},
                     std::vector<double>(center_.size())});
  }
  for (std::size_t i = 0; i < s_.branches.size(); ++i) {
    const auto width = std::size_t(s_.levels[std::size_t(s_.branches[i].root)].width);
    work_[i].spare.resize(width * (width + std::size_t(s_.globals)));
  }
  for (const Run& run : s_.runs) squares_.emplace_back(run.global.size() * run.global.size());
}

bool Elimination::factorize(const LinearSystem& system, const VectorXd& scale, double lambda) {
  // The branches, and the products of the globals, are independent of each other.
  const std::size_t branches = s_.branches.size();
  parallel::for_each(branches + s_.runs.size(), [&](std::size_t i) {
    if (i >= branches) return square_globals(system, i - branches);
    clear(s_.levels[std::size_t(s_.branches[i].begin)]);
    process(s_.branches[i], system, scale, lambda, work_[i]);
  });
  process_trunks(system, scale, lambda);
  Pivots pivots;
  for (const Work& w : work_) {
    if (!w.regular) return false;
    pivots.min = std::min(pivots.min, w.pivots.min);
    pivots.max = std::max(pivots.max, w.pivots.max);
  }
  sum_center(system, scale, lambda);
  return eliminate_center(pivots) && pivots.min > s_.min_pivot * pivots.max;
}

Elimination::Rows Elimination::rows_of(const Level& level) {
  return {panels_.data() + level.panel, level.width + level.parent_width,
          border_.data() + std::ptrdiff_t(level.first) * s_.globals};
}
void Elimination::clear(const Level& level) {
  const Rows rows = rows_of(level);
  std::fill_n(rows.panel, level.width * rows.stride, 0.0);
  std::fill_n(rows.border, level.width * s_.globals, 0.0);
}

// Assembles and eliminates the levels of a range, the first of which may hold numbers already.
void Elimination::process(const Range& range, const LinearSystem& system, const VectorXd& scale,
                          double lambda, Work& work) {
  const int g = s_.globals;
  work.pivots = Pivots{};
  work.regular = true;
  BorderedChain& chain = work.chain;
  chain.clear();
  const Level& first = s_.levels[std::size_t(range.begin)];
  const Rows begin = rows_of(first);
  chain.push(first.width);
  for (int i = 0; i < first.width; ++i) {
    const double* const from = begin.panel + i * begin.stride;
    for (int j = i; j < first.width; ++j) chain.information(i, j) = from[j];
    std::copy_n(begin.border + i * g, g, chain.row(i));
  }
  for (int l = range.begin; l < range.end && work.regular; ++l) {
    const Level& level = s_.levels[std::size_t(l)];
    if (level.parent >= 0) chain.push(level.parent_width);
    assemble(level, system, scale, work);
    for (int i = 0; i < level.width; ++i) chain.information(i, i) += lambda;
    chain.factorize();
    keep(level, work);
    chain.drop();
  }
  if (range.root >= 0) {
    const int n = s_.levels[std::size_t(range.root)].width;
    double* const spare = work.spare.data();
    for (int i = 0; i < n; ++i) {
      for (int j = i; j < n; ++j) spare[i * n + j] = chain.information(i, j);
      std::copy_n(chain.row(i), g, spare + n * n + i * g);
    }
  }
  chain.finish();
  for (int i = 0; i < g; ++i) {
    for (int j = i; j < g; ++j) work.center[std::size_t(i * g + j)] = -chain.border()(i, j);
  }
}

// A level's rows of U.
void Elimination::keep(const Level& level, Work& work) {
  const Rows own = rows_of(level);
  BorderedChain& chain = work.chain;
  for (int i = 0; i < level.width; ++i) {
    double* const to = own.panel + i * own.stride;
    for (int j = i; j < own.stride; ++j) to[j] = chain.information(i, j);
    std::copy_n(chain.row(i), s_.globals, own.border + i * s_.globals);
    inverse_diagonal_[std::size_t(level.first + i)] = chain.inverse(i);
    work.regular = work.regular && chain.inverse(i) > 0.0 && work.pivots.add(to[i] * to[i]);
  }
}

void Elimination::assemble(const Level& level, const LinearSystem& system, const VectorXd& scale,
                           Work& work) const {
  BorderedChain& chain = work.chain;
  double* J = work.jacobian.data();
  for (int f = level.factor_begin; f < level.factor_end; ++f) {
    const ChainFactor& factor = s_.factors[std::size_t(f)];
    const Shape& shape = s_.shapes[std::size_t(factor.shape)];
    const double* value = system.value().data() + factor.first_entry;
    const int* column = system.column().data() + factor.first_entry;
    for (int c = 0; c < shape.columns; ++c) {
      const double s = scale[column[c]];
      for (int e = c; e < shape.rows * shape.columns; e += shape.columns) J[e] = value[e] * s;
    }
    for (const Product& p : shape.products) {
      const bool to_own = p.into == Into::kOwn || p.into == Into::kOwnBorder;
      const bool to_border = p.into == Into::kOwnBorder || p.into == Into::kParentBorder;
      const int at = to_own ? 0 : chain.older();
      double* const out =
          to_border ? chain.row(at + p.row) + p.col : &chain.information(at + p.row, at + p.col);
      add_product(shape.rows, J + p.a, p.na, shape.columns, J + p.b, p.nb, shape.columns, out,
                  to_border ? chain.border().width() : chain.stride(), 1.0);
    }
  }
}

// The trunks follow one another: what the branches left is added in a fixed order.
void Elimination::process_trunks(const LinearSystem& system, const VectorXd& scale, double lambda) {
  for (const Range& trunk : s_.trunks) clear(s_.levels[std::size_t(trunk.begin)]);
  for (std::size_t i = 0; i < s_.branches.size(); ++i) {
    const Level& root = s_.levels[std::size_t(s_.branches[i].root)];
    const Rows rows = rows_of(root);
    const double* spare = work_[i].spare.data();
    for (int j = 0; j < root.width; ++j, spare += root.width) {
      subtract_row(rows.panel + j * rows.stride, spare, root.width, -1.0);
    }
    subtract_row(rows.border, spare, root.width * s_.globals, -1.0);
  }
  Work& work = work_.back();
  std::vector<double> sum(center_.size(), 0.0);
  Pivots pivots;
  bool regular = true;
  for (const Range& trunk : s_.trunks) {
    process(trunk, system, scale, lambda, work);
    subtract_row(sum.data(), work.center.data(), int(sum.size()), -1.0);
    pivots.min = std::min(pivots.min, work.pivots.min);
    pivots.max = std::max(pivots.max, work.pivots.max);
    regular = regular && work.regular;
  }
  work.center = std::move(sum);
  work.pivots = pivots;
  work.regular = regular;
}

void Elimination::square_globals(const LinearSystem& system, std::size_t i) {
  const Run& run = s_.runs[i];
  const auto n = int(run.global.size());
  std::fill(squares_[i].begin(), squares_[i].end(), 0.0);
  add_square(run.rows, system.value().data() + run.first_entry + run.first, n, run.columns,
             squares_[i].data(), n, 1.0);
}

// The globals' block once all else is eliminated: its upper triangle.
void Elimination::sum_center(const LinearSystem& system, const VectorXd& scale, double lambda) {
  const int g = s_.globals;
  double* center = center_.data();
  std::fill_n(center, center_.size(), 0.0);
  for (std::size_t r = 0; r < s_.runs.size(); ++r) {
    const std::vector<int>& global = s_.runs[r].global;
    const std::size_t n = global.size();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i; j < n; ++j) {
        if (global[i] < 0 || global[j] < 0) continue;
        center[std::min(global[i], global[j]) * g + std::max(global[i], global[j])] +=
            squares_[r][i * n + j];
      }
    }
  }
  VectorXd s(g);
  for (int c = 0; c < system.cols(); ++c) {
    const int p = s_.position[std::size_t(c)];
    if (p >= s_.chain) s[p - s_.chain] = scale[c];
  }
  for (int i = 0; i < g; ++i) {
    for (int j = i; j < g; ++j) center[i * g + j] *= s[i] * s[j];
    center[i * (g + 1)] += lambda;
  }
  for (const Work& w : work_) subtract_row(center_.data(), w.center.data(), g * g, 1.0);
}

}  // namespace magimu::chain
