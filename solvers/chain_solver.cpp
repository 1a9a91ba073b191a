// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/chain_solver.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <type_traits>
#include <utility>

#include "solvers/ordering.h"

namespace magimu {
namespace {

constexpr int kMaxWidth = 40, kMaxGlobals = 512;
constexpr int kMinBranch = 32;     // levels; shorter chains are eliminated in one go
constexpr int kRunFactors = 1024;  // factors whose globals' products are one task
constexpr int kStrip = 96;         // rows of a long product that are taken at a time

// ---- Small dense products ------------------------------------------------------------------

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

// ---- Structure -----------------------------------------------------------------------------

struct Level {
  int first = 0, width = 0;  // its positions in the order of elimination
  int parent = -1;           // the level to which it is coupled among those eliminated later
  int parent_width = 0;
  std::size_t panel = 0;  // where its rows [U | W] of width + parent_width columns start
  int factor_begin = 0, factor_end = 0;
};

// Levels that are eliminated one after another; the last is coupled to level `root`, if any.
struct Range {
  int begin, end, root;
};

// Where a product of two groups of a factor's columns goes.
enum class Into { kOwn, kOwnBorder, kParent, kParentBorder };
struct Product {
  int a, na, b, nb;
  Into into;
  int row, col;
};
// What factors have in common whose columns lie alike relative to their level.
struct Shape {
  int rows, columns;
  std::vector<Product> products;
};
struct ChainFactor {
  int first_entry, shape;
};

// Successive factors with the same globals; those are among the local columns first to
// first + global.size(); -1 for the others.
struct Run {
  int first_entry, rows, columns, first;
  std::vector<int> global;
};

struct Structure {
  int chain = 0, globals = 0;
  // Columns have unit norm, so this is zero up to rounding, which adds up along a chain: a singular
  // one of n columns passes with a pivot of about 1e-17 n.
  double min_pivot = 1e-14;
  std::vector<int> position;  // of a column: chain in the order of elimination, then globals
  std::vector<Level> levels;
  std::vector<Range> branches, trunks;  // all branches first, then the trunks they lead to
  std::size_t panels = 0;
  std::vector<ChainFactor> factors;  // by level
  std::vector<Shape> shapes;
  std::vector<Run> runs;
};

class Analysis {
 public:
  explicit Analysis(const LinearSystem& system) : system_(system) {
    const auto start = system.variable_start();
    variables_ = int(start.size()) - 1;
    variable_of_.resize(std::size_t(system.cols()));
    for (int v = 0; v < variables_; ++v) {
      for (int c = begin(v); c < begin(v + 1); ++c) variable_of_[std::size_t(c)] = v;
    }
  }

  // False if the system has no such structure with these columns as globals.
  bool find(const std::vector<int>& is_global, Structure& out) {
    out = Structure{};
    out.position.assign(std::size_t(system_.cols()), 0);
    int next = 0;
    for (const int g : is_global) out.globals += g;
    if (out.globals > kMaxGlobals) return false;
    out.chain = system_.cols() - out.globals;
    for (int c = 0; c < system_.cols(); ++c) {
      if (is_global[std::size_t(c)] != 0) out.position[std::size_t(c)] = out.chain + next++;
    }
    join_variables(is_global);
    if (!find_levels(is_global, out)) return false;
    assign_factors(out);
    find_runs(out);
    return true;
  }

 private:
  using Levels = std::vector<std::vector<int>>;

  int begin(int variable) const { return system_.variable_start()[std::size_t(variable)]; }
  int width(int variable) const { return begin(variable + 1) - begin(variable); }
  int column_at(int entry) const { return system_.column().data()[entry]; }
  int variable_of(int entry) const { return variable_of_[std::size_t(column_at(entry))]; }
  template <class Body>
  void for_each_factor(const Body& body) const {
    for (const LinearSystem::RowBlocks& b : system_.row_blocks()) {
      for (int i = 0; i < b.count; ++i) body(b, b.first_entry + i * b.rows * b.columns);
    }
  }

  // Both lists of the bipartite graph of variables that are not global and factors.
  void join_variables(const std::vector<int>& is_global) {
    variables_in_.clear();
    factors_on_.assign(std::size_t(variables_), {});
    for_each_factor([&](const LinearSystem::RowBlocks& b, int entry) {
      const int factor = int(variables_in_.size());
      std::vector<int>& list = variables_in_.emplace_back();
      for (int c = 0; c < b.columns;) {
        const int v = variable_of(entry + c);
        if (is_global[std::size_t(begin(v))] == 0) {
          list.push_back(v);
          factors_on_[std::size_t(v)].push_back(factor);
        }
        c += width(v);
      }
    });
    seen_variable_.assign(std::size_t(variables_), 0);
    seen_factor_.assign(variables_in_.size(), 0);
    pass_ = 0;
  }

  // Breadth-first levels; all variables of a factor lie in one level or in two successive ones.
  Levels levels_from(const std::vector<int>& start) {
    ++pass_;
    for (const int v : start) seen_variable_[std::size_t(v)] = pass_;
    Levels levels{start};
    for (std::vector<int> next;; next.clear()) {
      for (const int v : levels.back()) {
        for (const int f : factors_on_[std::size_t(v)]) {
          if (std::exchange(seen_factor_[std::size_t(f)], pass_) == pass_) continue;
          for (const int w : variables_in_[std::size_t(f)]) {
            if (std::exchange(seen_variable_[std::size_t(w)], pass_) != pass_) next.push_back(w);
          }
        }
      }
      if (next.empty()) return levels;
      std::sort(next.begin(), next.end());
      levels.push_back(next);
    }
  }
  int level_width(const std::vector<int>& level) const {
    return std::accumulate(level.begin(), level.end(), 0,
                           [this](int sum, int v) { return sum + width(v); });
  }
  double work(const Levels& levels) const {
    double sum = 0.0;
    for (const auto& level : levels) sum += std::pow(double(level_width(level)), 3.0);
    return sum;
  }

  bool find_levels(const std::vector<int>& is_global, Structure& out) {
    std::vector<char> done(std::size_t(variables_), 0);
    for (int v = 0; v < variables_; ++v) {
      if (done[std::size_t(v)] != 0 || is_global[std::size_t(begin(v))] != 0) continue;
      // From an end; then back from the whole far end: where several variables make up a node, one
      // alone would be a level before the others of its node.
      const Levels there = levels_from({levels_from({v}).back().front()});
      const Levels back = levels_from(there.back());
      const Levels& levels = work(back) <= work(there) ? back : there;
      int columns = 0;
      for (const auto& level : levels) {
        if (level_width(level) > kMaxWidth) return false;
        columns += level_width(level);
        for (const int w : level) done[std::size_t(w)] = 1;
      }
      out.min_pivot = std::max(out.min_pivot, 1e-16 * columns);
      add_component(levels, out);
    }
    for (Range& trunk : trunks_) trunk = append(trunk_levels_[std::size_t(trunk.begin)], -1, out);
    for (std::size_t i = 0; i < out.branches.size(); ++i) {
      Range& branch = out.branches[i];
      branch.root = trunks_[std::size_t(branch.root)].begin;
      couple(branch.end - 1, branch.root, out);
    }
    out.trunks = std::exchange(trunks_, {});
    trunk_levels_.clear();
    for (Level& level : out.levels) {
      level.panel = out.panels;
      out.panels += std::size_t(level.width) * std::size_t(level.width + level.parent_width);
    }
    return true;
  }

  // Long chains are eliminated from both ends to the middle, which is the trunk.
  void add_component(const Levels& levels, Structure& out) {
    const auto trunk = int(trunks_.size());
    trunks_.push_back({trunk, 0, -1});
    if (levels.size() < 2 * kMinBranch) {
      trunk_levels_.push_back(levels);
      return;
    }
    const auto middle = std::ptrdiff_t(levels.size() / 2);
    out.branches.push_back(append({levels.begin(), levels.begin() + middle}, trunk, out));
    out.branches.push_back(append({levels.rbegin(), levels.rend() - middle - 1}, trunk, out));
    trunk_levels_.push_back({levels[std::size_t(middle)]});
  }

  Range append(const Levels& levels, int root, Structure& out) {
    const Range range{int(out.levels.size()), int(out.levels.size() + levels.size()), root};
    for (const auto& variables : levels) {
      Level level;
      level.first = next_position_;
      for (const int v : variables) {
        for (int c = begin(v); c < begin(v + 1); ++c) {
          out.position[std::size_t(c)] = next_position_++;
          level_of_.resize(std::size_t(next_position_), int(out.levels.size()));
        }
      }
      level.width = next_position_ - level.first;
      out.levels.push_back(level);
    }
    for (int l = range.begin; l + 1 < range.end; ++l) couple(l, l + 1, out);
    return range;
  }
  static void couple(int level, int parent, Structure& out) {
    out.levels[std::size_t(level)].parent = parent;
    out.levels[std::size_t(level)].parent_width = out.levels[std::size_t(parent)].width;
  }

  // A factor is added with the first of its levels to be eliminated.
  void assign_factors(Structure& out) {
    std::vector<std::vector<ChainFactor>> of_level(out.levels.size());
    std::map<std::vector<int>, int> shapes;
    std::vector<int> signature, last_signature;
    int last_shape = -1;
    for_each_factor([&](const LinearSystem::RowBlocks& b, int entry) {
      int own = int(out.levels.size());
      for (int c = 0; c < b.columns; ++c) {
        const int p = out.position[std::size_t(column_at(entry + c))];
        if (p < out.chain) own = std::min(own, level_of_[std::size_t(p)]);
      }
      if (own == int(out.levels.size())) return;
      signature = places(b, entry, out.levels[std::size_t(own)], out);
      if (signature != last_signature) {
        const auto [it, added] = shapes.try_emplace(signature, int(out.shapes.size()));
        if (added) out.shapes.push_back(shape(b, signature));
        last_shape = it->second;
        last_signature = signature;
      }
      of_level[std::size_t(own)].push_back({entry, last_shape});
    });
    for (std::size_t l = 0; l < of_level.size(); ++l) {
      out.levels[l].factor_begin = int(out.factors.size());
      out.factors.insert(out.factors.end(), of_level[l].begin(), of_level[l].end());
      out.levels[l].factor_end = int(out.factors.size());
    }
  }

  // For each column of a factor: its place in [own level | parent | globals], and last the numbers
  // of rows and of columns of the own level.
  std::vector<int> places(const LinearSystem::RowBlocks& b, int entry, const Level& level,
                          const Structure& out) const {
    std::vector<int> place(std::size_t(b.columns) + 2);
    for (int c = 0; c < b.columns; ++c) {
      const int p = out.position[std::size_t(column_at(entry + c))];
      int& q = place[std::size_t(c)];
      if (p >= out.chain) {
        q = 2 * kMaxWidth + p - out.chain;
      } else if (p < level.first + level.width) {
        q = p - level.first;
      } else {
        q = kMaxWidth + p - out.levels[std::size_t(level.parent)].first;
      }
    }
    place[std::size_t(b.columns)] = b.rows;
    place[std::size_t(b.columns) + 1] = level.width;
    return place;
  }

  static Shape shape(const LinearSystem::RowBlocks& b, const std::vector<int>& place) {
    struct Group {  // successive columns of one kind: 0 own, 1 parent, 2 global
      int column, count, kind, place;
    };
    std::vector<Group> groups;
    for (int c = 0; c < b.columns; ++c) {
      const int kind = std::min(place[std::size_t(c)] / kMaxWidth, 2);
      const int at = place[std::size_t(c)] - kind * kMaxWidth;
      if (!groups.empty() && groups.back().kind == kind &&
          groups.back().place + groups.back().count == at) {
        ++groups.back().count;
      } else {
        groups.push_back({c, 1, kind, at});
      }
    }
    Shape out{b.rows, b.columns, {}};
    for (const Group& i : groups) {
      for (const Group& j : groups) {
        if (i.kind == 2 || j.kind < i.kind || (j.kind == i.kind && j.place < i.place)) continue;
        const Into into = j.kind == 2 ? (i.kind == 0 ? Into::kOwnBorder : Into::kParentBorder)
                                      : (i.kind == 0 ? Into::kOwn : Into::kParent);
        const int shift = i.kind == 0 && j.kind == 1 ? place.back() : 0;
        out.products.push_back(
            {i.column, i.count, j.column, j.count, into, i.place, j.place + shift});
      }
    }
    return out;
  }

  void find_runs(Structure& out) const {
    for (const LinearSystem::RowBlocks& b : system_.row_blocks()) {
      std::vector<int> global(std::size_t(b.columns)), last;
      int in_run = 0;
      for (int i = 0; i < b.count; ++i) {
        const int entry = b.first_entry + i * b.rows * b.columns;
        for (int c = 0; c < b.columns; ++c) {
          const int p = out.position[std::size_t(column_at(entry + c))];
          global[std::size_t(c)] = p < out.chain ? -1 : p - out.chain;
        }
        const auto is = [](int g) { return g >= 0; };
        const auto first = std::find_if(global.begin(), global.end(), is);
        if (first == global.end()) {
          last.clear();
          continue;
        }
        if (global != last || in_run == kRunFactors) {
          const auto end = std::find_if(global.rbegin(), global.rend(), is).base();
          out.runs.push_back({entry, 0, b.columns, int(first - global.begin()), {first, end}});
          last = global;
          in_run = 0;
        }
        out.runs.back().rows += b.rows;
        ++in_run;
      }
    }
  }

  const LinearSystem& system_;
  int variables_ = 0;
  std::vector<int> variable_of_;
  std::vector<std::vector<int>> variables_in_, factors_on_;
  std::vector<int> seen_variable_, seen_factor_;
  int pass_ = 0;
  std::vector<Range> trunks_;
  std::vector<Levels> trunk_levels_;
  int next_position_ = 0;
  std::vector<int> level_of_;  // of each position
};

// A second opinion on the globals, for short or many recordings: columns with many more rows than
// most have.
std::vector<int> crowded_columns(const LinearSystem& system) {
  std::vector<int> count(std::size_t(system.cols()), 0);
  for (const int c : system.column()) ++count[std::size_t(c)];
  std::vector<int> sorted = count;
  const auto middle = sorted.begin() + std::ptrdiff_t(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const int many = 4 * *middle;
  for (int& c : count) c = c > many ? 1 : 0;
  return count;
}

bool find_structure(const LinearSystem& system, Structure& out) {
  return Analysis(system).find(global_columns(system), out) ||
         Analysis(system).find(crowded_columns(system), out);
}

// ---- Numbers -------------------------------------------------------------------------------

// The extreme pivots so far.
struct Pivots {
  double min = 1.0, max = 1.0;
  bool add(double p) {
    min = std::min(min, p);
    max = std::max(max, p);
    return p > 0.0 && std::isfinite(p);
  }
};

// x *= s; y -= s x.
inline void scale_row(double* x, int n, double s) {
  for (int j = 0; j < n; ++j) x[j] *= s;
}
inline void subtract_row(double* y, const double* x, int n, double s) {
  for (int j = 0; j < n; ++j) y[j] -= s * x[j];
}

// [A B] and G of `width` rows become U and U^-T [B G], where U'U = A; A's upper triangle counts.
bool eliminate(double* panel, int width, int columns, double* border, int globals,
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

// A level's rows: those of its panel, `stride` apart, and of the border.
struct Rows {
  double* panel = nullptr;
  int stride = 0;
  double* border = nullptr;
};

class ChainSolver final : public LinearSolver {
 public:
  explicit ChainSolver(Structure structure) : s_(std::move(structure)) {
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

  bool factorize(const LinearSystem& system, const VectorXd& scale, double lambda) override {
    // The branches, and the products of the globals, are independent of each other.
    const std::size_t branches = s_.branches.size();
    tbb::parallel_for(std::size_t(0), branches + s_.runs.size(), [&](std::size_t i) {
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

  VectorXd solve(const LinearSystem& system, const VectorXd& scale) override {
    return solve_normal(-scale.cwiseProduct(system.gradient()));
  }

  MatrixXd solve_normal(const MatrixXd& B) override {
    MatrixXd X(B.rows(), B.cols());
    if (B.cols() == 1) {
      solve_columns<1>(B, X, 0);
      return X;
    }
    tbb::parallel_for(Eigen::Index(0), (B.cols() + kColumns - 1) / kColumns,
                      [&](Eigen::Index i) { solve_columns<kColumns>(B, X, i * kColumns); });
    return X;
  }

 private:
  static constexpr int kColumns = 8;  // right-hand sides that are solved for at a time

  struct Work {
    std::vector<double> jacobian;  // of one factor, scaled
    std::vector<double> spare;     // what a branch adds to its root: A, then the border
    std::vector<double> center;    // what it subtracts from the globals' block
    Pivots pivots;
    bool regular = true;
  };

  Rows rows_of(const Level& level) {
    return {panels_.data() + level.panel, level.width + level.parent_width,
            border_.data() + std::ptrdiff_t(level.first) * s_.globals};
  }
  void clear(const Level& level) {
    const Rows rows = rows_of(level);
    std::fill_n(rows.panel, level.width * rows.stride, 0.0);
    std::fill_n(rows.border, level.width * s_.globals, 0.0);
  }

  // Assembles and eliminates the levels of a range, the first of which may hold numbers already.
  void process(const Range& range, const LinearSystem& system, const VectorXd& scale, double lambda,
               Work& work) {
    const int g = s_.globals;
    work.pivots = Pivots{};
    work.regular = true;
    std::fill(work.center.begin(), work.center.end(), 0.0);
    std::fill(work.spare.begin(), work.spare.end(), 0.0);
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
        add_square(rows, border_.data() + std::ptrdiff_t(first) * g, g, g, work.center.data(), g,
                   1.0);
        begin = l + 1;
      }
    }
  }

  // Where a level's contributions to its parent go: to the next level, or to the branch's spare.
  Rows parent_rows(const Range& range, int l, Work& work) {
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

  void assemble(const Level& level, const Rows& own, const Rows& parent, const LinearSystem& system,
                const VectorXd& scale, Work& work) const {
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
  void process_trunks(const LinearSystem& system, const VectorXd& scale, double lambda) {
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

  void square_globals(const LinearSystem& system, std::size_t i) {
    const Run& run = s_.runs[i];
    const auto n = int(run.global.size());
    std::fill(squares_[i].begin(), squares_[i].end(), 0.0);
    add_square(run.rows, system.value().data() + run.first_entry + run.first, n, run.columns,
               squares_[i].data(), n, 1.0);
  }

  // The globals' block once all else is eliminated: its upper triangle.
  void sum_center(const LinearSystem& system, const VectorXd& scale, double lambda) {
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

  // Columns first to first + N of the solution for those of B, as many as there are.
  template <int N>
  void solve_columns(const MatrixXd& B, MatrixXd& X, Eigen::Index first) const {
    using RowsOfN =
        Eigen::Matrix<double, Eigen::Dynamic, N, N == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
    const Eigen::Index count = std::min<Eigen::Index>(N, B.cols() - first);
    RowsOfN x = RowsOfN::Zero(B.rows(), N);
    for (Eigen::Index c = 0; c < B.rows(); ++c) {
      for (Eigen::Index k = 0; k < count; ++k) x(s_.position[std::size_t(c)], k) = B(c, first + k);
    }
    for (const Level& level : s_.levels) forward(level, x);
    const int g = s_.globals;
    Level center;
    center.first = s_.chain;
    center.width = g;
    forward_rows(center, center_.data(), nullptr, x);
    backward_rows(center, center_.data(), nullptr, x);
    for (std::size_t l = s_.levels.size(); l-- > 0;) backward(s_.levels[l], x);
    for (Eigen::Index c = 0; c < B.rows(); ++c) {
      for (Eigen::Index k = 0; k < count; ++k) X(c, first + k) = x(s_.position[std::size_t(c)], k);
    }
  }
  template <class M>
  void forward(const Level& level, M& x) const {
    forward_rows(level, panels_.data() + level.panel, border_of(level), x);
  }
  template <class M>
  void backward(const Level& level, M& x) const {
    backward_rows(level, panels_.data() + level.panel, border_of(level), x);
  }
  const double* border_of(const Level& level) const {
    return border_.data() + std::ptrdiff_t(level.first) * s_.globals;
  }
  int parent_first(const Level& level) const {
    return level.parent < 0 ? 0 : s_.levels[std::size_t(level.parent)].first;
  }

  template <class M>
  void forward_rows(const Level& level, const double* row, const double* border, M& x) const {
    const int d = level.width, n = level.parent_width, parent = parent_first(level);
    for (int i = 0; i < d; ++i, row += d + n) {
      x.row(level.first + i) *= inverse_diagonal_.data()[level.first + i];
      const auto xi = x.row(level.first + i).eval();
      for (int k = i + 1; k < d; ++k) x.row(level.first + k) -= row[k] * xi;
      for (int k = 0; k < n; ++k) x.row(parent + k) -= row[d + k] * xi;
      if (border == nullptr) continue;
      for (int k = 0; k < s_.globals; ++k) x.row(s_.chain + k) -= *border++ * xi;
    }
  }
  template <class M>
  void backward_rows(const Level& level, const double* panel, const double* border, M& x) const {
    const int d = level.width, n = level.parent_width, parent = parent_first(level);
    for (int i = d - 1; i >= 0; --i) {
      const double* row = panel + i * (d + n);
      auto xi = x.row(level.first + i).eval();
      for (int k = i + 1; k < d; ++k) xi -= row[k] * x.row(level.first + k);
      for (int k = 0; k < n; ++k) xi -= row[d + k] * x.row(parent + k);
      if (border != nullptr) {
        const double* g = border + i * s_.globals;
        for (int k = 0; k < s_.globals; ++k) xi -= g[k] * x.row(s_.chain + k);
      }
      x.row(level.first + i) = xi * inverse_diagonal_.data()[level.first + i];
    }
  }

  Structure s_;
  std::vector<double> panels_, border_, inverse_diagonal_, center_;
  std::vector<Work> work_;                    // one for each branch, the last for the trunks
  std::vector<std::vector<double>> squares_;  // J'J of each run's globals, not scaled
};

}  // namespace

std::unique_ptr<LinearSolver> make_chain_solver(const LinearSystem& system) {
  Structure structure;
  if (!find_structure(system, structure)) return nullptr;
  return std::make_unique<ChainSolver>(std::move(structure));
}

}  // namespace magimu
