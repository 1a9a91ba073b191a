// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/window_layout.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "graph/parallel.h"
#include "graph/slot_finder.h"
#include "solvers/linear/chain_levels.h"
#include "statistics/quantiles.h"

namespace magimu::lanes {
namespace {

constexpr int kMinNodes = 64;      // below, other solvers are as fast
constexpr int kWindowNodes = 400;  // about as many are one window in a long recording
constexpr int kMinWindowNodes = 12;
constexpr int kTwoGroups = 1500;  // nodes; fewer are one group
constexpr int kWideNodes = 6000;  // least number of nodes in a group where the border is wide
constexpr int kManyTimes = 4;     // globals have more than this times the factors of most variables
constexpr int kMaxGlobals = 512;  // columns
constexpr int kAtOnce = 256;  // factors of which more than one thing is asked while they are near

class Search {
 public:
  Search(const FactorGraph& graph, const Values& values) : graph_(graph), values_(values) {}

  bool find(Layout& out) { return resolve(out) && find_globals(out) && find_nodes(out); }
  const std::vector<int>& chain_ends() const { return chain_ends_; }

 private:
  int slots() const { return values_.size(); }
  const Values::Slot& slot(int i) const { return values_.slots()[std::size_t(i)]; }

  // The batches side by side.
  bool resolve(Layout& out) {
    out.factor.resize(graph_.batches().size());
    out.noise.resize(out.factor.size());
    std::vector<char> fits(out.factor.size(), 0);
    parallel::for_each(fits.size(), [&](std::size_t b) {
      fits[b] = resolve(*graph_.batches()[b], out.factor[b], out.noise[b]) ? 1 : 0;
    });
    return std::count(fits.begin(), fits.end(), 0) == 0;
  }
  bool resolve(const FactorBatch& batch, std::vector<int>& found, NoiseKinds& noise) const {
    const auto types = batch.types();
    found.resize(std::size_t(batch.size()) * types.size());
    SlotFinder finder(values_, types.size());
    int* next = found.data();
    for (int i = 0; i < batch.size(); ++i) {
      if (i % kAtOnce == 0) {
        const NoiseKinds more = batch.noise_kinds(i, std::min(i + kAtOnce, batch.size()));
        noise = {noise.diagonal && more.diagonal, noise.same && more.same, more.robust};
        if (noise.robust) return false;
      }
      const auto keys = batch.keys(i);
      for (std::size_t j = 0; j < types.size(); ++j) {
        const int s = finder.find(j, keys[j]);
        if (s < 0 || !(slot(s).type == types[j])) return false;
        *next++ = s;
      }
    }
    return true;
  }

  bool find_globals(Layout& out) {
    std::vector<int> factors(std::size_t(slots()), 0);
    for (const auto& list : out.factor) {
      for (const int s : list) ++factors[std::size_t(s)];
    }
    if (std::count(factors.begin(), factors.end(), 0) > 0) return false;
    const int many = kManyTimes * quantile(factors, 0.5);
    out.variables.assign(std::size_t(slots()), {0, 0, 0});
    for (int s = 0; s < slots(); ++s) {
      if (factors[std::size_t(s)] <= many) continue;
      out.variables[std::size_t(s)] = {-1, out.globals_stored, out.globals};
      out.globals += slot(s).type.tangent();
      out.globals_stored += slot(s).type.stored();
    }
    return out.globals <= kMaxGlobals;
  }

  // Variables of each factor, globals aside.
  Lists join(const Layout& out) const {
    Lists joined;
    for (std::size_t f = 0; f < out.factor.size(); ++f) {
      const std::size_t n = graph_.batches()[f]->types().size();
      const std::vector<int>& list = out.factor[f];
      for (std::size_t at = 0; at < list.size(); at += n) {
        for (std::size_t i = at; i < at + n; ++i) {
          if (!is_global(out, list[i])) joined.entries.push_back(list[i]);
        }
        joined.close();
      }
    }
    return joined;
  }
  static bool is_global(const Layout& out, int s) { return out.variables[std::size_t(s)].node < 0; }

  // Mostly the variables of a node have one index, and the nodes follow each other by it: then one
  // look at each factor tells that it is so.
  bool nodes_by_index(Layout& out) {
    std::uint32_t low = ~0U, high = 0;
    int variables = 0;
    for (int s = 0; s < slots(); ++s) {
      if (is_global(out, s)) continue;
      low = std::min(low, slot(s).key.index);
      high = std::max(high, slot(s).key.index);
      ++variables;
    }
    if (variables == 0 || high - low >= std::uint32_t(variables)) return false;
    const int count = int(high - low) + 1;
    const auto node = [&](int s) { return int(slot(s).key.index - low); };
    std::vector<char> linked(std::size_t(count), 0);  // with the next
    for (std::size_t f = 0; f < out.factor.size(); ++f) {
      const std::size_t n = graph_.batches()[f]->types().size();
      const std::vector<int>& list = out.factor[f];
      for (std::size_t at = 0; at < list.size(); at += n) {
        int first = count, last = -1;
        for (std::size_t k = at; k < at + n; ++k) {
          if (is_global(out, list[k])) continue;
          first = std::min(first, node(list[k]));
          last = std::max(last, node(list[k]));
        }
        if (last > first + 1) return false;
        if (last == first + 1) linked[std::size_t(first)] = 1;
      }
    }
    const int each = variables / count;
    if (each * count != variables) return false;
    Lists all;
    all.entries.assign(std::size_t(variables), -1);
    std::vector<int> filled(std::size_t(count), 0);
    for (int s = 0; s < slots(); ++s) {
      if (is_global(out, s)) continue;
      int& k = filled[std::size_t(node(s))];
      if (k == each) return false;
      all.entries[std::size_t(node(s) * each + k++)] = s;
    }
    for (int first = 0; first < count;) {
      int end = first + 1;
      while (linked[std::size_t(end) - 1] != 0) ++end;
      Lists chain;
      chain.entries.assign(all.entries.begin() + first * each, all.entries.begin() + end * each);
      for (int i = 1; i <= end - first; ++i) chain.begin.push_back(i * each);
      if (!append(chain, out)) return false;
      first = end;
    }
    return true;
  }

  bool find_nodes(Layout& out) {
    Layout guess = out;
    if (nodes_by_index(guess)) {
      out = std::move(guess);
      return true;
    }
    chain_ends_.clear();
    types_.clear();
    const Lists joined = join(out);
    std::vector<int> widths;
    for (int s = 0; s < slots(); ++s) widths.push_back(slot(s).type.tangent());
    ChainLevels finder(joined, std::move(widths));
    std::vector<char> done(std::size_t(slots()), 0);
    for (int s = 0; s < slots(); ++s) {
      if (done[std::size_t(s)] != 0 || is_global(out, s)) continue;
      const Lists levels = finder.of(s);
      for (const int v : levels.entries) done[std::size_t(v)] = 1;
      if (!append(levels, out)) return false;
    }
    return int(out.slots.size()) > 0;
  }

  // Nodes of one chain, if they are like those that are there.
  bool append(const Lists& levels, Layout& out) {
    const int count = levels.size();
    if (count < 2) return false;
    if (out.node.empty()) {
      for (const int s : levels[0]) {
        const VariableType type = slot(s).type;
        out.node.push_back({out.stored, out.d, type.tangent(), type.kind == 'R'});
        out.stored += type.stored();
        out.d += type.tangent();
        types_.push_back(type);
      }
      if (out.d > kMaxNode) return false;
    }
    for (int level = 0; level < count; ++level) {
      const auto own = levels[level];
      if (own.size() != types_.size()) return false;
      const int number = int(out.slots.size() / types_.size());
      for (std::size_t k = 0; k < own.size(); ++k) {
        if (!(slot(own[k]).type == types_[k])) return false;
        out.variables[std::size_t(own[k])] = {number, out.node[k].stored, out.node[k].tangent};
        out.slots.push_back(own[k]);
      }
    }
    chain_ends_.push_back(int(out.slots.size() / types_.size()));
    return true;
  }

  const FactorGraph& graph_;
  const Values& values_;
  std::vector<VariableType> types_;
  std::vector<int> chain_ends_;  // number of nodes after each chain
};

void cut(const std::vector<int>& chain_ends, int lanes, Layout& out) {
  const int total = chain_ends.back();
  // Full groups, an even number of them where there are many, and two at once where each has enough
  // to do.
  int groups = std::max(1, total / (lanes * kWindowNodes));
  if (groups == 1 && total >= kTwoGroups) groups = 2;
  // Each group costs a square of the border.
  if (out.b() > kWideBorder) groups = std::min(groups, std::max(2, total / kWideNodes));
  if (groups > 4) groups = (groups + 3) / 4 * 4;
  const int length = std::max(kMinWindowNodes, (total + lanes * groups - 1) / (lanes * groups));
  out.window_of.resize(std::size_t(total));
  int begin = 0;
  for (const int end : chain_ends) {
    const int links = end - 1 - begin, count = std::max(1, (links + length - 1) / length);
    for (int w = 0; w < count; ++w) {
      const auto at = [&](int i) { return begin + int(std::int64_t(links) * i / count); };
      out.windows.push_back({at(w), at(w + 1), 0, 0, w == 0});
      for (int n = at(w); n <= at(w + 1); ++n)
        out.window_of[std::size_t(n)] = int(out.windows.size()) - 1;
    }
    begin = end;
  }
  for (const Layout::Window& w : out.windows) {
    out.window_of[std::size_t(w.first)] = int(&w - out.windows.data());
  }
  // Windows of like length side by side.
  std::vector<int> order(out.windows.size());
  std::iota(order.begin(), order.end(), 0);
  const auto links = [&](int w) {
    return out.windows[std::size_t(w)].last - out.windows[std::size_t(w)].first;
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return links(a) > links(b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const int group = int(i) / lanes, lane = int(i) % lanes;
    if (lane == 0)
      out.groups.push_back({links(order[i]), std::vector<int>(std::size_t(lanes), -1)});
    out.groups.back().windows[std::size_t(lane)] = order[i];
    out.windows[std::size_t(order[i])].group = group;
    out.windows[std::size_t(order[i])].lane = lane;
  }
}

}  // namespace

std::optional<Layout> find_layout(const FactorGraph& graph, const Values& values, int lanes) {
  Layout out;
  if (values.size() < kMinNodes) return std::nullopt;
  Search search(graph, values);
  if (!search.find(out) || search.chain_ends().back() < kMinNodes) return std::nullopt;
  cut(search.chain_ends(), lanes, out);
  return out;
}

}  // namespace magimu::lanes
