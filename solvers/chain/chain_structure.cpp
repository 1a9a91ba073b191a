// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/chain/chain_structure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "solvers/linear/chain_levels.h"
#include "solvers/linear/ordering.h"
#include "statistics/quantiles.h"

namespace magimu::chain {
namespace {

constexpr int kMaxWidth = 40, kMaxGlobals = 512;
constexpr int kFar = 8;            // times the usual distance between variables of one factor
constexpr int kMinBranch = 32;     // levels; shorter chains are eliminated in one go
constexpr int kRunFactors = 1024;  // factors whose globals' products are one task

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
    if (!find_levels(is_global, out)) return false;
    assign_factors(out);
    find_runs(out);
    return true;
  }

  // These globals, and those that only few factors share (a lever arm, which one factor every few
  // seconds sees). Their factors' other variables are far from them in the order of variables,
  // while a node is near most variables of its factors.
  std::vector<int> with_far_reaching(std::vector<int> globals) const {
    std::vector<std::vector<int>> distances(static_cast<std::size_t>(variables_));
    for_each_factor([&](const LinearSystem::RowBlocks& b, int entry) {
      for (int c = 0; c < b.columns; c += width(variable_of(entry + c))) {
        const int v = variable_of(entry + c);
        for (int d = 0; d < b.columns; d += width(variable_of(entry + d))) {
          const int w = variable_of(entry + d);
          if (w == v || globals[std::size_t(begin(w))] != 0) continue;
          distances[std::size_t(v)].push_back(std::abs(w - v));
        }
      }
    });
    std::vector<int> usual;
    for (const std::vector<int>& of : distances) {
      usual.push_back(of.empty() ? 0 : quantile(of, 0.25));
    }
    const int far = kFar * std::max(1, quantile(usual, 0.5));
    for (int v = 0; v < variables_; ++v) {
      if (usual[std::size_t(v)] <= far) continue;
      std::fill(globals.begin() + begin(v), globals.begin() + begin(v + 1), 1);
    }
    return globals;
  }

 private:
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

  // Variables of each factor, not global.
  Lists join_variables(const std::vector<int>& is_global) const {
    Lists out;
    for_each_factor([&](const LinearSystem::RowBlocks& b, int entry) {
      for (int c = 0; c < b.columns;) {
        const int v = variable_of(entry + c);
        if (is_global[std::size_t(begin(v))] == 0) out.entries.push_back(v);
        c += width(v);
      }
      out.close();
    });
    return out;
  }

  bool find_levels(const std::vector<int>& is_global, Structure& out) {
    const Lists joined = join_variables(is_global);
    std::vector<int> widths(std::size_t(variables_), 0);
    for (int v = 0; v < variables_; ++v) widths[std::size_t(v)] = width(v);
    ChainLevels finder(joined, std::move(widths));
    std::vector<char> done(std::size_t(variables_), 0);
    for (int v = 0; v < variables_; ++v) {
      if (done[std::size_t(v)] != 0 || is_global[std::size_t(begin(v))] != 0) continue;
      const Lists levels = finder.of(v);
      int columns = 0;
      for (int l = 0; l < levels.size(); ++l) {
        const int level = finder.width(levels[l]);
        if (level > kMaxWidth) return false;
        columns += level;
        for (const int w : levels[l]) done[std::size_t(w)] = 1;
      }
      out.min_pivot = std::max(out.min_pivot, 3e-17 * columns);
      add_component(levels, out);
    }
    for (Range& trunk : trunks_) {
      const Lists& levels = trunk_levels_[std::size_t(trunk.begin)];
      trunk = append(levels, 0, levels.size(), -1, out);
    }
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
  void add_component(const Lists& levels, Structure& out) {
    const auto trunk = int(trunks_.size());
    trunks_.push_back({trunk, 0, -1});
    if (levels.size() < 2 * kMinBranch) {
      trunk_levels_.push_back(levels);
      return;
    }
    const int middle = levels.size() / 2;
    out.branches.push_back(append(levels, 0, middle, trunk, out));
    out.branches.push_back(append(levels, levels.size() - 1, middle, trunk, out));
    Lists& trunk_levels = trunk_levels_.emplace_back();
    trunk_levels.entries.assign(levels[middle].begin(), levels[middle].end());
    trunk_levels.close();
  }

  // Levels from begin_level on, upwards or downwards, up to end_level, which is not one of them.
  Range append(const Lists& levels, int begin_level, int end_level, int root, Structure& out) {
    const int count = std::abs(end_level - begin_level), step = begin_level < end_level ? 1 : -1;
    const Range range{int(out.levels.size()), int(out.levels.size()) + count, root};
    for (int l = begin_level; l != end_level; l += step) {
      Level level;
      level.first = next_position_;
      for (const int v : levels[l]) {
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
    std::vector<ChainFactor> found;
    Lists level_of;  // of each of them
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
      find_places(b, entry, out.levels[std::size_t(own)], out, signature);
      if (signature != last_signature) {
        const auto [it, added] = shapes.try_emplace(signature, int(out.shapes.size()));
        if (added) out.shapes.push_back(shape(b, signature));
        last_shape = it->second;
        last_signature = signature;
      }
      found.push_back({entry, last_shape});
      level_of.entries.push_back(own);
      level_of.close();
    });
    const Lists factors_of = inverted(level_of, int(out.levels.size()));
    for (const int f : factors_of.entries) out.factors.push_back(found[std::size_t(f)]);
    for (std::size_t l = 0; l < out.levels.size(); ++l) {
      out.levels[l].factor_begin = factors_of.begin[l];
      out.levels[l].factor_end = factors_of.begin[l + 1];
    }
  }

  // For each column of a factor: its place in [own level | parent | globals], and last the numbers
  // of rows and of columns of the own level.
  void find_places(const LinearSystem::RowBlocks& b, int entry, const Level& level,
                   const Structure& out, std::vector<int>& place) const {
    place.resize(std::size_t(b.columns) + 2);
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
  std::vector<Range> trunks_;
  std::vector<Lists> trunk_levels_;
  int next_position_ = 0;
  std::vector<int> level_of_;  // of each position
};

// Another guess at the globals, for short or many recordings: columns with more than four times the
// median number of rows.
std::vector<int> crowded_columns(const LinearSystem& system) {
  std::vector<int> count(std::size_t(system.cols()), 0);
  for (const int c : system.column()) ++count[std::size_t(c)];
  const int many = 4 * quantile(count, 0.5);
  for (int& c : count) c = c > many ? 1 : 0;
  return count;
}

}  // namespace

std::optional<Structure> find_structure(const LinearSystem& system) {
  Structure out;
  const std::vector<int> shared = global_columns(system), crowded = crowded_columns(system);
  if (Analysis(system).find(shared, out) || Analysis(system).find(crowded, out) ||
      Analysis(system).find(Analysis(system).with_far_reaching(shared), out) ||
      Analysis(system).find(Analysis(system).with_far_reaching(crowded), out)) {
    return out;
  }
  return std::nullopt;
}

}  // namespace magimu::chain
