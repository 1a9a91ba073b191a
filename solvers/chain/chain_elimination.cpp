// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/chain/chain_elimination.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>

#include "graph/parallel.h"
#include "solvers/kernels/square_sum.h"

namespace magimu::chain {
namespace {

constexpr int kStrip = 96;  // rows of a long product that are taken at a time
// Globals from which their square is worth a copy of the rows into SIMD registers' order: of an
// array of magnetometers it is nearly all of the work.
constexpr int kWideBorder = 64;

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

// C += A'A (upper triangle) for a tall A of n columns, side by side as C's are; gathered until
// finish().
class BorderSquare {
 public:
  BorderSquare(int n, double* c) : n_(n), c_(c) {
    if (n >= kWideBorder) wide_.emplace(n);
  }
  void add(const double* a, int rows) {
    if (!wide_) return add_square(rows, a, n_, n_, c_, n_, 1.0);
    constexpr int kTogether = 32;
    for (int k = 0; k < rows; k += kTogether) {
      const int count = std::min(kTogether, rows - k);
      double* to = wide_->rows(count);
      for (int i = k; i < k + count; ++i, to += wide_->width()) {
        std::copy_n(a + std::ptrdiff_t(i) * n_, n_, to);
      }
    }
  }
  void finish() {
    if (!wide_) return;
    wide_->finish();
    for (int i = 0; i < n_; ++i) {
      for (int j = i; j < n_; ++j) c_[std::ptrdiff_t(i) * n_ + j] += (*wide_)(i, j);
    }
  }

 private:
  int n_;
  double* c_;
  std::optional<SquareSum> wide_;
};

// x *= s; y -= s x.
inline void scale_row(double* x, int n, double s) {
  for (int j = 0; j < n; ++j) x[j] *= s;
}
inline void subtract_row(double* y, const double* x, int n, double s) {
  for (int j = 0; j < n; ++j) y[j] -= s * x[j];
}

}  // namespace

// [A B] and G of `width` rows become U and U^-T [B G], where U'U = A; A's upper triangle counts.
bool Elimination::eliminate(double* panel, int width, int columns, double* border, int globals,
                            double* inverse_diagonal, Pivots& pivots) {
  for (int i = 0; i < width; ++i) {
    double* row = panel + i * columns;
    double* g = border + i * globals;
    if (!pivots.add(row[i])) return false;
    const double scale = 1.0 / std::sqrt(row[i]);
    inverse_diagonal[i] = scale;
    scale_row(row + i, columns - i, scale);
    scale_row(g, globals, scale);
    for (int k = i + 1; k < width; ++k) {
      subtract_row(panel + k * columns + k, row + k, columns - k, row[k]);
      subtract_row(border + k * globals, g, globals, row[k]);
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
  work_.resize(s_.branches.size() + 1);
  for (Work& w : work_) {
    w.jacobian.resize(jacobian);
    w.center.resize(center_.size());
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
  const int g = s_.globals;
  if (!eliminate(center_.data(), g, g, nullptr, 0, inverse_diagonal_.data() + s_.chain, pivots)) {
    return false;
  }
  return pivots.min > s_.min_pivot * pivots.max;
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
  std::fill(work.center.begin(), work.center.end(), 0.0);
  std::fill(work.spare.begin(), work.spare.end(), 0.0);
  BorderSquare center(g, work.center.data());
  int begin = range.begin;  // of the levels whose border is not yet in work.center
  for (int l = range.begin; l < range.end && work.regular; ++l) {
    const Level& level = s_.levels[std::size_t(l)];
    const Rows own = rows_of(level);
    const Rows parent = parent_rows(range, l, work);
    assemble(level, own, parent, system, scale, work);
    for (int i = 0; i < level.width; ++i) own.panel[i * (own.stride + 1)] += lambda;
    work.regular = eliminate(own.panel, level.width, own.stride, own.border, g,
                             inverse_diagonal_.data() + level.first, work.pivots);
    const double* W = own.panel + level.width;
    const int d = level.width, n = level.parent_width;
    add_product(d, W, n, own.stride, W, n, own.stride, parent.panel, parent.stride, -1.0, true);
    add_product(d, W, n, own.stride, own.border, g, g, parent.border, g, -1.0);
    const int first = s_.levels[std::size_t(begin)].first, rows = level.first + d - first;
    if (rows >= kStrip || l + 1 == range.end) {
      center.add(border_.data() + std::ptrdiff_t(first) * g, rows);
      begin = l + 1;
    }
  }
  center.finish();
}

// Where a level's contributions to its parent go: to the next level, or to the branch's spare.
Elimination::Rows Elimination::parent_rows(const Range& range, int l, Work& work) {
  const Level& level = s_.levels[std::size_t(l)];
  if (level.parent < 0) return {};
  if (l + 1 == range.end) {
    const int n = level.parent_width;
    return {work.spare.data(), n, work.spare.data() + n * n};
  }
  const Level& next = s_.levels[std::size_t(l) + 1];
  clear(next);
  return rows_of(next);
}

void Elimination::assemble(const Level& level, const Rows& own, const Rows& parent,
                           const LinearSystem& system, const VectorXd& scale, Work& work) const {
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
      const Rows& rows = to_own ? own : parent;
      const int stride = to_border ? s_.globals : rows.stride;
      double* out = (to_border ? rows.border : rows.panel) + p.row * stride + p.col;
      add_product(shape.rows, J + p.a, p.na, shape.columns, J + p.b, p.nb, shape.columns, out,
                  stride, 1.0);
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
