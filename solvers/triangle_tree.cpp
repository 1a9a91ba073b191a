// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/triangle_tree.h"

#include <algorithm>
#include <bit>

namespace magimu {

void TriangleTree::append(CondensedTriangle leaf) {
  changed_.push_back(size());
  leaves_.push_back(std::move(leaf));
  last_.emplace_back();
  solved_.push_back(0);
}

void TriangleTree::replace(int leaf, CondensedTriangle with) {
  leaves_[std::size_t(leaf)] = std::move(with);
  changed_.push_back(leaf);
}

int TriangleTree::count(int level) const {
  return level == 0 ? size() : int(levels_[std::size_t(level) - 1].size());
}

const CondensedTriangle& TriangleTree::triangle(int level, int i) const {
  while (level > 0 && 2 * i + 1 >= count(level - 1)) {  // no right child: the left one passes
    --level;
    i *= 2;
  }
  return level == 0 ? leaves_[std::size_t(i)]
                    : levels_[std::size_t(level) - 1][std::size_t(i)].triangle;
}

int TriangleTree::refresh(int globals) {
  int merges = 0;
  for (int level = 1; count(level - 1) > 1; ++level) {
    if (int(levels_.size()) < level) levels_.emplace_back();
    std::vector<Vertex>& vertices = levels_[std::size_t(level) - 1];
    vertices.resize(std::size_t(count(level - 1) + 1) / 2);
    for (int& i : changed_) i /= 2;
    std::sort(changed_.begin(), changed_.end());
    changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
    for (const int i : changed_) {
      if (2 * i + 1 >= count(level - 1)) continue;
      Vertex& v = vertices[std::size_t(i)];
      v.triangle =
          merge(triangle(level - 1, 2 * i), triangle(level - 1, 2 * i + 1), globals, &v.shared);
      ++merges;
    }
  }
  changed_.clear();
  return merges;
}

CondensedTriangle TriangleTree::root_with(int leaf, const CondensedTriangle& instead,
                                          int globals) const {
  CondensedTriangle out = instead;
  for (int level = 0, i = leaf; count(level) > 1; ++level, i /= 2) {
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

}  // namespace magimu
