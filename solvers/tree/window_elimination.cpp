// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/tree/window_elimination.h"

#include <algorithm>
#include <map>
#include <optional>

#include "graph/so3.h"
#include "solvers/kernels/row_chain.h"

namespace magimu {
namespace {

constexpr int kGatheredOfWindow = 96;  // of first node and globals alone, before they are condensed

int slot_index(const Values& values, Key key) {
  return int(&values.slot(key) - values.slots().data());
}

// Rows of [first | globals | d] that inner nodes have left behind.
class Gathered {
 public:
  explicit Gathered(int columns) : rows_(2 * kGatheredOfWindow, columns) {}

  void push(const RowStack::View& A, int begin, int end) {
    if (filled_ + end - begin > rows_.rows()) condense();
    if (filled_ + end - begin > rows_.rows()) {
      rows_.conservativeResize(filled_ + end - begin, Eigen::NoChange);
    }
    rows_.middleRows(filled_, end - begin) =
        A.block(begin, A.cols() - rows_.cols(), end - begin, rows_.cols());
    filled_ += end - begin;
  }
  auto rows() const { return rows_.topRows(filled_); }
  int size() const { return filled_; }
  double squares() const { return squares_; }

 private:
  void condense() {
    RowBlock A = rows_.topRows(filled_);
    std::vector<int> pivots;
    const int columns = int(A.cols()) - 1, next = triangularize(A, 0, 0, columns, pivots);
    squares_ += A.col(columns).tail(A.rows() - next).squaredNorm();
    rows_.topRows(next) = A.topRows(next);
    filled_ = next;
  }
  RowBlock rows_;
  int filled_ = 0;
  double squares_ = 0.0;
};

}  // namespace

WindowElimination::WindowElimination(const std::vector<const FactorGraph*>& graphs,
                                     const Values& values,
                                     const std::function<bool(Key)>& is_global,
                                     std::optional<std::uint32_t> first) {
  number_nodes(values, is_global, first, graphs);
  resolve(graphs, values);
}

void WindowElimination::number_nodes(const Values& values,
                                     const std::function<bool(Key)>& is_global,
                                     std::optional<std::uint32_t> first,
                                     const std::vector<const FactorGraph*>& graphs) {
  std::map<std::uint32_t, int> node_of;  // by index: 0, 1, ... along the chain
  for (const Values::Slot& s : values.slots()) {
    if (!is_global(s.key) && s.key.index != first) node_of[s.key.index] = 0;
  }
  int nodes = 0;
  for (auto& [index, node] : node_of) node = nodes++;
  // A factor joins one level to the next at most: nodes that it steps over are one level with the
  // first of its two.
  std::vector<char> with_next(std::size_t(nodes), 0);
  const auto is_inner = [&](Key k) { return !is_global(k) && k.index != first; };
  for (const FactorGraph* graph : graphs) {
    for (const auto& batch : graph->batches()) {
      for (int i = 0; i < batch->size(); ++i) {
        int low = nodes, high = -1;
        for (const Key k : batch->keys(i)) {
          if (!is_inner(k) || !node_of.contains(k.index)) continue;
          low = std::min(low, node_of[k.index]);
          high = std::max(high, node_of[k.index]);
        }
        for (int n = low; n + 2 <= high; ++n) with_next[std::size_t(n)] = 1;
      }
    }
  }
  std::vector<int> level_of(std::size_t(nodes), 0);
  int level = 0;
  for (int n = 0; n < nodes; ++n) {
    level_of[std::size_t(n)] = level;
    if (with_next[std::size_t(n)] == 0) ++level;
  }
  levels_.resize(std::size_t(std::max(level, 1)));
  for (const Values::Slot& s : values.slots()) {
    const int width = s.type.tangent();
    Variable v{Place::kGlobal, -1, 0, s.type.kind == 'R'};
    if (is_global(s.key)) {
      v.offset = globals_;
      globals_ += width;
    } else if (s.key.index == first) {
      v.place = Place::kFirst;
      v.offset = first_;
      first_ += width;
    } else {
      v.level = level_of[std::size_t(node_of[s.key.index])];
      v.place = v.level + 1 == int(levels_.size()) ? Place::kLast : Place::kInner;
      Level& own = levels_[std::size_t(v.level)];
      v.offset = own.width;
      own.width += width;
      for (int c = 0; c < width; ++c) own.columns.push_back(s.tangent + c);
    }
    variables_.push_back(v);
    width_of_.push_back(width);
  }
}

void WindowElimination::resolve(const std::vector<const FactorGraph*>& graphs,
                                const Values& values) {
  rows_.assign(graphs.size(), 0);
  for (std::size_t g = 0; g < graphs.size(); ++g) {
    for (std::size_t b = 0; b < graphs[g]->batches().size(); ++b) {
      const FactorBatch& batch = *graphs[g]->batches()[b];
      Batch own{g, b, batch.rows(), batch.columns(), {}, {}, batch.types().size()};
      rows_[g] += batch.rows() * batch.size();
      for (int i = 0; i < batch.size(); ++i) {
        int level = int(levels_.size()) - 1;
        for (const Key key : batch.keys(i)) {
          const int slot = slot_index(values, key);
          const Values::Slot& s = values.slots()[std::size_t(slot)];
          own.keys.stored.push_back(s.stored);
          own.keys.tangent.push_back(s.tangent);
          own.variables.push_back(slot);
          const Variable& v = variables_[std::size_t(slot)];
          if (v.level >= 0) level = std::min(level, v.level);
        }
        levels_[std::size_t(level)].factors.emplace_back(int(batches_.size()), i);
        levels_[std::size_t(level)].rows += batch.rows();
      }
      batches_.push_back(std::move(own));
    }
  }
}

WindowElimination::Linearized WindowElimination::linearize(
    const std::vector<const FactorGraph*>& graphs, const std::vector<bool>& used,
    const Values& at) const {
  Linearized out;
  out.r.resize(batches_.size());
  out.J.resize(batches_.size());
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    if (!used[batches_[b].graph]) continue;
    const FactorBatch& batch = *graphs[batches_[b].graph]->batches()[batches_[b].index];
    out.r[b].resize(std::size_t(batch.size() * batch.rows()));
    out.J[b].resize(out.r[b].size() * std::size_t(batch.columns()));
    batch.linearize(at.data(), batches_[b].keys, 0, batch.size(), out.r[b].data(), out.J[b].data());
  }
  return out;
}

// Of a window at one point: factors' rows in columns [own | next | first | globals | d].
struct WindowElimination::Assembly {
  Assembly(const WindowElimination& window, const Linearized& linearized,
           const WindowCoordinates& point)
      : w(window),
        numbers(linearized),
        coordinates(w.variables_.size()),
        chart(coordinates.size()) {
    for (std::size_t s = 0; s < w.variables_.size(); ++s) {
      const Variable& v = w.variables_[s];
      if (v.place == Place::kInner) continue;
      const VectorXd& x = v.place == Place::kGlobal  ? point.globals
                          : v.place == Place::kFirst ? point.first
                                                     : point.last;
      coordinates[s] = x.data() + v.offset;
      if (v.rotation) chart[s] = so3::left_jacobian(Vector3(x.segment<3>(v.offset)));
    }
  }

  void add(const std::pair<int, int>& factor, int level, int own, int next, double* row,
           std::ptrdiff_t stride, int d) const {
    const Batch& b = w.batches_[std::size_t(factor.first)];
    const auto i = std::size_t(factor.second), rows = std::size_t(b.rows);
    const double* const r = numbers.r[std::size_t(factor.first)].data() + i * rows;
    const double* J =
        numbers.J[std::size_t(factor.first)].data() + i * rows * std::size_t(b.columns);
    for (int k = 0; k < b.rows; ++k) row[k * stride + d] = r[k];
    for (std::size_t k = 0; k < b.per_factor; ++k) {
      const auto slot = std::size_t(b.variables[i * b.per_factor + k]);
      const Variable& v = w.variables_[slot];
      int to = v.offset;
      if (v.place == Place::kGlobal) to += own + next + w.first_;
      if (v.place == Place::kFirst) to += own + next;
      if (v.level > level) to += own;
      add_block(b, slot, J, row, stride, to, d);
      J += w.width_of_[slot];
    }
  }

 private:
  void add_block(const Batch& b, std::size_t slot, const double* J, double* row,
                 std::ptrdiff_t stride, int to, int d) const {
    const int width = w.width_of_[slot];
    const double* const x = coordinates[slot];
    const bool turned = x != nullptr && w.variables_[slot].rotation;
    for (int k = 0; k < b.rows; ++k, J += b.columns, row += stride) {
      double* const target = row + to;
      if (turned) {
        Eigen::Map<Eigen::RowVector3d>(target).noalias() =
            Eigen::Map<const Eigen::RowVector3d>(J).lazyProduct(chart[slot]);
      } else {
        for (int c = 0; c < width; ++c) target[c] = J[c];
      }
      if (x == nullptr) continue;
      for (int c = 0; c < width; ++c) row[d] -= J[c] * x[c];
    }
  }

  const WindowElimination& w;
  const Linearized& numbers;
  std::vector<const double*> coordinates;  // of variables with an anchor; null: without
  std::vector<Matrix3> chart;              // of rotations: d (move from the point) / d (coordinate)
};

CondensedTriangle WindowElimination::condense(const Linearized& linearized,
                                              const std::vector<bool>& used,
                                              const WindowCoordinates& point,
                                              std::vector<EliminatedNode>* nodes) const {
  const Assembly assembly(*this, linearized, point);
  const int border = first_ + globals_ + 1;
  Gathered gathered(border);
  thread_local RowChain chain;
  chain.reset(border);
  if (nodes != nullptr) nodes->clear();
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const Level& level = levels_[l];
    const bool is_last = l + 1 == levels_.size();
    const int own = level.width, next = is_last ? 0 : levels_[l + 1].width;
    int rows = is_last ? gathered.size() : 0;
    for (const auto& f : level.factors) {
      const Batch& b = batches_[std::size_t(f.first)];
      if (used[b.graph]) rows += b.rows;
    }
    RowStack& stack = chain.stack(own, next, rows);
    RowStack::View A = stack.view();
    int row = chain.first_row();
    for (const auto& f : level.factors) {
      if (!used[batches_[std::size_t(f.first)].graph]) continue;
      assembly.add(f, int(l), own, next, A.data() + row * A.outerStride(), A.outerStride(),
                   int(A.cols()) - 1);
      row += batches_[std::size_t(f.first)].rows;
    }
    if (is_last) {
      A.bottomRightCorner(gathered.size(), border) = gathered.rows();
      std::vector<int> pivots;
      const int below = triangularize(stack, 0, 0, own + border - 1, pivots);
      CondensedTriangle out{own, first_, globals_, RowBlock::Zero(own + border - 1, own + border),
                            gathered.squares()};
      for (std::size_t p = 0; p < pivots.size(); ++p) {
        if (pivots[p] >= 0) out.R.row(Eigen::Index(p)) = A.row(pivots[p]);
      }
      out.squares += A.col(A.cols() - 1).tail(A.rows() - below).squaredNorm();
      return out;
    }
    chain.eliminate();
    if (nodes != nullptr) {
      EliminatedNode node{own, next, first_, globals_, RowBlock(own, A.cols())};
      for (std::size_t p = 0; p < chain.pivots().size(); ++p) {
        if (chain.pivots()[p] >= 0) {
          node.R.row(Eigen::Index(p)) = A.row(chain.pivots()[p]);
        } else {
          node.R.row(Eigen::Index(p)).setZero();
        }
      }
      nodes->push_back(std::move(node));
    }
    gathered.push(A, chain.end_of_next(), int(A.rows()));
  }
  return {};
}

VectorXd WindowElimination::solve(const std::vector<EliminatedNode>& nodes,
                                  const WindowCoordinates& to) const {
  int columns = 0;
  for (const int w : width_of_) columns += w;
  VectorXd out = VectorXd::Zero(columns), next = to.last;
  for (std::size_t l = nodes.size(); l-- > 0;) {
    next = nodes[l].solve(next, to.first, to.globals);
    for (int c = 0; c < levels_[l].width; ++c) out[levels_[l].columns[std::size_t(c)]] = next[c];
  }
  return out;
}

}  // namespace magimu
