// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/tree/triangle_tree.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace magimu {

void TriangleTree::append(CondensedTriangle leaf) {
  changed_.push_back(size());
  leaves_.push_back({std::move(leaf), {}});
  last_.emplace_back();
  solved_.push_back(0);
}

void TriangleTree::replace(int leaf, CondensedTriangle with) {
  Leaf& l = leaves_[std::size_t(leaf)];
  if (asleep(leaf)) {
    l.packed = PackedTriangle(with);
  } else {
    l.triangle = std::move(with);
  }
  changed_.push_back(leaf);
}

CondensedTriangle TriangleTree::leaf(int i) const {
  const Leaf& l = leaves_[std::size_t(i)];
  return asleep(i) ? l.packed.unpacked() : l.triangle;
}

double TriangleTree::moved_squares(int leaf, const VectorXd& delta) const {
  const Leaf& l = leaves_[std::size_t(leaf)];
  return asleep(leaf) ? l.packed.moved_squares(delta) : magimu::moved_squares(l.triangle, delta);
}

int TriangleTree::count(int level) const {
  return level == 0 ? size() : int(levels_[std::size_t(level) - 1].size());
}

const CondensedTriangle& TriangleTree::triangle(int level, int i) const {
  while (level > 0 && 2 * i + 1 >= count(level - 1)) {  // no right child: the left one passes
    --level;
    i *= 2;
  }
  return level == 0 ? leaves_[std::size_t(i)].triangle
                    : levels_[std::size_t(level) - 1][std::size_t(i)].triangle;
}

// Of a stretch that sleeps, or a part of it: its shared nodes are stored, its triangle is not.
CondensedTriangle TriangleTree::remade(int level, int i, int globals) {
  if (level == 0) return leaf(i);
  return merge(remade(level - 1, 2 * i, globals), remade(level - 1, 2 * i + 1, globals), globals,
               &levels_[std::size_t(level) - 1][std::size_t(i)].shared);
}

int TriangleTree::refresh(int globals) {
  int merges = 0;
  std::sort(changed_.begin(), changed_.end());
  const auto awake = std::lower_bound(changed_.begin(), changed_.end(), asleep_);
  std::vector<int> stretches(changed_.begin(), awake);
  for (int& s : stretches) s /= kStretch;
  stretches.erase(std::unique(stretches.begin(), stretches.end()), stretches.end());
  changed_.erase(changed_.begin(), awake);
  for (const int s : stretches) {
    levels_[kStretchLevels - 1][std::size_t(s)].triangle = remade(kStretchLevels, s, globals);
    merges += kStretch - 1;
  }
  for (int level = 1; count(level - 1) > 1; ++level) {
    if (int(levels_.size()) < level) levels_.emplace_back();
    std::vector<Vertex>& vertices = levels_[std::size_t(level) - 1];
    vertices.resize(std::size_t(count(level - 1) + 1) / 2);
    for (int& i : changed_) i /= 2;
    changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
    for (const int i : changed_) {
      if (2 * i + 1 >= count(level - 1)) continue;
      Vertex& v = vertices[std::size_t(i)];
      v.triangle =
          merge(triangle(level - 1, 2 * i), triangle(level - 1, 2 * i + 1), globals, &v.shared);
      ++merges;
    }
    if (level == kStretchLevels) {  // those that sleep come before all others
      changed_.insert(changed_.begin(), stretches.begin(), stretches.end());
    }
  }
  changed_.clear();
  return merges;
}

void TriangleTree::sleep(int end) {
  const int from = asleep_;
  asleep_ = std::max(asleep_, end / kStretch * kStretch);
  for (int i = from; i < asleep_; ++i) {
    Leaf& l = leaves_[std::size_t(i)];
    l.packed = PackedTriangle(std::exchange(l.triangle, {}));
  }
  for (int level = 1; level < kStretchLevels; ++level) {
    for (int i = from >> level; i < asleep_ >> level; ++i) {
      levels_[std::size_t(level) - 1][std::size_t(i)].triangle = {};
    }
  }
}

// Of a stretch that sleeps, or a part of it, with another triangle for one leaf.
CondensedTriangle TriangleTree::merged_with(int level, int i, int which,
                                            const CondensedTriangle& instead, int globals) const {
  if (level == 0) return i == which ? instead : leaf(i);
  return merge(merged_with(level - 1, 2 * i, which, instead, globals),
               merged_with(level - 1, 2 * i + 1, which, instead, globals), globals, nullptr);
}

CondensedTriangle TriangleTree::root_with(int leaf, const CondensedTriangle& instead,
                                          int globals) const {
  const int begin = asleep(leaf) ? kStretchLevels : 0;
  CondensedTriangle out = merged_with(begin, leaf >> begin, leaf, instead, globals);
  for (int level = begin, i = leaf >> begin; count(level) > 1; ++level, i /= 2) {
    const bool is_left = i % 2 == 0;
    if (is_left && i + 1 >= count(level)) continue;
    out = is_left ? merge(out, triangle(level, i + 1), globals, nullptr)
                  : merge(triangle(level, i - 1), out, globals, nullptr);
  }
  return out;
}

void TriangleTree::set_solution(const VectorXd& last, const VectorXd& globals) {
  ++solution_;
  globals_ = globals;
  last_.back() = last;
  solved_.back() = solution_;
}

const VectorXd& TriangleTree::last_of(int leaf) const {
  VectorXd& own = last_[std::size_t(leaf)];
  if (solved_[std::size_t(leaf)] == solution_) return own;
  // The node after `leaf` was eliminated where the leaves to both sides of it met.
  const int level = std::countr_zero(unsigned(leaf) + 1U) + 1, i = leaf >> level;
  const int first = (i << level) - 1, last = std::min(size(), (i + 1) << level) - 1;
  const VectorXd none;
  own = levels_[std::size_t(level) - 1][std::size_t(i)].shared.solve(
      last_of(last), first < 0 ? none : last_of(first), globals_);
  solved_[std::size_t(leaf)] = solution_;
  return own;
}

std::vector<MatrixXd> TriangleTree::follow_globals(int globals) const {
  std::vector<MatrixXd> out(leaves_.size());
  const auto follow = [globals](const auto& T, MatrixXd B, const auto& of_globals) {
    B.leftCols(of_globals.cols()) += of_globals;
    for (int g = 0; g < globals; ++g) B.col(g) = substitute(T, B.col(g));
    return B;
  };
  const CondensedTriangle& t = root();
  out.back() = follow(t.R.topLeftCorner(t.last, t.last), MatrixXd::Zero(t.last, globals),
                      t.R.block(0, t.last, t.last, t.globals));
  // Vertices from the root down: what they eliminated lies between nodes that are known by then.
  for (int level = int(levels_.size()); level > 0; --level) {
    for (int i = 0; 2 * i + 1 < count(level - 1); ++i) {
      const EliminatedNode& node = levels_[std::size_t(level) - 1][std::size_t(i)].shared;
      const int begin = i << level, last = std::min(size(), (i + 1) << level) - 1;
      MatrixXd B =
          node.R.middleCols(node.width, node.last) * out[std::size_t(last)].topRows(node.last);
      if (node.first > 0) {
        B += node.R.middleCols(node.width + node.last, node.first) * out[std::size_t(begin) - 1];
      }
      out[std::size_t(((2 * i + 1) << (level - 1)) - 1)] =
          follow(node.R.leftCols(node.width), std::move(B),
                 node.R.middleCols(node.width + node.last + node.first, node.globals));
    }
  }
  return out;
}

}  // namespace magimu
