// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/incremental_qr.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace magimu {
namespace {

constexpr int kRounds = 4;  // of linearization in one update, while that is cheap
constexpr int kNewest = 2;  // windows whose drift is always looked at

std::string name_of(std::span<const Key> keys) {
  std::string text = "the factor on (";
  for (std::size_t i = 0; i < keys.size(); ++i) text += (i > 0 ? ", " : "") + to_string(keys[i]);
  return text + ")";
}

template <class Body>
void for_each_factor(const FactorGraph& graph, const Body& body) {
  for (const auto& batch : graph.batches()) {
    for (int i = 0; i < batch->size(); ++i) body(batch->keys(i), batch->types());
  }
}

}  // namespace

int IncrementalQr::find_chain(const FactorGraph& graph, const Values& new_values) const {
  int chain = -1;
  for_each_factor(graph, [&](std::span<const Key> keys, std::span<const VariableType> types) {
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const Key key = keys[k];
      const Values& known = new_values.contains(key) ? new_values : globals_;
      if (known.contains(key)) {
        if (known.slot(key).type == types[k]) continue;
        throw std::invalid_argument(name_of(keys) + " takes " + to_string(key) + " for a " +
                                    to_string(types[k]) + ", but it is a " +
                                    to_string(known.slot(key).type));
      }
      int found = -1;
      for (std::size_t c = 0; c < chains_.size() && !options_.is_global(key); ++c) {
        const Values& last = windows_[std::size_t(chains_[c].windows.back())].values;
        if (key.index == chains_[c].last_index && last.contains(key)) found = int(c);
      }
      if (found < 0) {
        throw std::invalid_argument(
            name_of(keys) + " needs " + to_string(key) +
            ", which is neither new nor a global nor of the last node of a chain: a window can "
            "only join nodes of its own and the node before it; give a graph with such a loop to "
            "LevenbergMarquardt, or all windows of the loop in one update");
      }
      if (chain >= 0 && chain != found) {
        throw std::invalid_argument(name_of(keys) +
                                    " is of another chain than the window's other factors: a "
                                    "window continues one chain");
      }
      chain = found;
    }
  });
  return chain;
}

IncrementalQr::Window IncrementalQr::make_window(const FactorGraph& factors,
                                                 const Values& new_values,
                                                 const FactorGraph& removable) {
  const int chain = std::max(find_chain(factors, new_values), find_chain(removable, new_values));
  Window w;
  w.factors = factors;
  w.removable = removable;
  std::uint32_t low = std::numeric_limits<std::uint32_t>::max(), high = 0;
  for (const Values::Slot& s : new_values.slots()) {
    if (options_.is_global(s.key)) continue;
    w.own.push_back(s.key);
    low = std::min(low, s.key.index);
    high = std::max(high, s.key.index);
  }
  if (w.own.empty() && chain >= 0) {
    throw std::invalid_argument("an update with factors on " +
                                std::to_string(chains_[std::size_t(chain)].last_index) +
                                ", the last node of a chain, must bring a new node as well");
  }
  for (std::size_t c = 0; c < chains_.size() && !w.own.empty(); ++c) {
    const bool after = int(c) == chain
                           ? low > chains_[c].last_index
                           : low > chains_[c].last_index || high < chains_[c].first_index;
    if (after) continue;
    throw std::invalid_argument("the new nodes " + std::to_string(low) + " to " +
                                std::to_string(high) + " do not come after node " +
                                std::to_string(chains_[c].last_index) +
                                " of the chain that is there already: number nodes along each "
                                "chain, and chains apart");
  }
  // All is well: from here on this object changes.
  for (const Values::Slot& s : new_values.slots()) {
    if (!options_.is_global(s.key)) continue;
    anchors_.insert_from(new_values, s.key);
    globals_.insert_from(new_values, s.key);
    const VectorXd old = x_globals_;
    x_globals_ = VectorXd::Zero(anchors_.dim());
    x_globals_.head(old.size()) = old;
  }
  std::optional<std::uint32_t> first;
  w.values = globals_;
  w.point.globals = x_globals_;
  if (chain >= 0) {
    const Chain& c = chains_[std::size_t(chain)];
    const Values now = front();
    first = c.last_index;
    w.point.first = c.last;
    const Window& before = windows_[std::size_t(c.windows.back())];
    const auto& variables = before.elimination.variables();
    for (std::size_t s = 0; s < variables.size(); ++s) {
      if (variables[s].place != WindowElimination::Place::kLast) continue;
      w.values.insert_from(now, before.values.slots()[s].key);
    }
  }
  for (const Key key : w.own) w.values.insert_from(new_values, key);
  w.elimination =
      WindowElimination({&w.factors, &w.removable}, w.values, options_.is_global, first);
  w.point.last = VectorXd::Zero(w.elimination.last_width());
  w.chain = chain;
  if (!w.own.empty()) {
    if (chain < 0) {
      w.chain = int(chains_.size());
      chains_.emplace_back();
      chains_.back().first_index = low;
    }
    chains_[std::size_t(w.chain)].last_index = high;
  }
  return w;
}

CondensedTriangle IncrementalQr::condense(Window& w, bool with_removable, bool keep) const {
  return w.elimination.condense({&w.factors, &w.removable}, {true, with_removable}, w.values,
                                w.point, keep ? &w.nodes : nullptr);
}

void IncrementalQr::put(int window) {
  Window& w = windows_[std::size_t(window)];
  CondensedTriangle t = condense(w, !w.removed, true);
  if (w.chain < 0) {
    w.triangle = std::move(t);
    return;
  }
  Chain& chain = chains_[std::size_t(w.chain)];
  if (w.leaf < 0) {
    w.leaf = chain.tree.size();
    chain.windows.push_back(window);
    chain.tree.append(std::move(t));
  } else {
    chain.tree.replace(w.leaf, std::move(t));
  }
}

int IncrementalQr::refresh() {
  int merges = 0;
  for (Chain& chain : chains_) merges += chain.tree.refresh(anchors_.dim());
  return merges;
}

// The root's solution, and from it the last nodes. Returns the globals' step in sigmas.
double IncrementalQr::solve() {
  const int globals = anchors_.dim();
  root_ = CondensedTriangle{0, 0, 0, RowBlock(0, 1)};
  bool first = true;
  const auto add = [&](const CondensedTriangle& t) {
    root_ = first && t.globals == globals ? t : sum(root_, t, globals);
    first = false;
  };
  for (const Chain& chain : chains_) add(without_last(chain.tree.root()));
  for (const int w : loose_) add(windows_[std::size_t(w)].triangle);
  const VectorXd x = magimu::solve(root_, kNullTolerance);
  const double step = (root_.R.leftCols(globals) * (x - x_globals_)).norm();
  x_globals_ = x;
  globals_ = anchors_.retract({x.data(), std::size_t(x.size())});
  for (Chain& chain : chains_) {
    const CondensedTriangle& t = chain.tree.root();
    const VectorXd b =
        t.R.topRightCorner(t.last, 1) + t.R.block(0, t.last, t.last, t.globals) * x.head(t.globals);
    chain.last = substitute(t.R.topLeftCorner(t.last, t.last), b);
    chain.tree.set_solution(chain.last, x);
  }
  return step;
}

void IncrementalQr::look(int window) {
  const Window& w = windows_[std::size_t(window)];
  const WindowCoordinates to = coordinates(w);
  const CondensedTriangle& t =
      w.chain < 0 ? w.triangle : chains_[std::size_t(w.chain)].tree.leaf(w.leaf);
  VectorXd delta(t.width());
  delta << to.last - w.point.last, to.first - w.point.first, to.globals - w.point.globals;
  const int rows = w.elimination.rows(0) + (w.removed ? 0 : w.elimination.rows(1));
  double drift = (t.R.leftCols(t.width()) * delta).norm() / std::sqrt(double(std::max(rows, 1))) /
                 options_.tolerance;
  for (const WindowElimination::Variable& v : w.elimination.variables()) {
    if (!v.rotation || v.place == WindowElimination::Place::kInner) continue;
    const int at = v.offset + (v.place == WindowElimination::Place::kLast    ? 0
                               : v.place == WindowElimination::Place::kFirst ? t.last
                                                                             : t.last + t.first);
    drift = std::max(drift, delta.segment<3>(at).norm() / options_.max_rotation);
  }
  drift_[std::size_t(window)] = drift;
}

// The newest windows of each chain, and some of the others in turn.
void IncrementalQr::look_around() {
  for (Chain& chain : chains_) {
    const int n = chain.tree.size(), looks = std::min(n, options_.looked_at);
    for (int k = 1; k <= std::min(n, kNewest); ++k) look(chain.windows[std::size_t(n - k)]);
    for (int k = 0; k < looks; ++k) {
      chain.looked_at = (chain.looked_at + 1) % n;
      look(chain.windows[std::size_t(chain.looked_at)]);
    }
  }
}

// The worst-drifted windows, so many at most, linearized where the estimate is. False if none was
// in need of it.
bool IncrementalQr::relinearize(int limit, UpdateResult& result) {
  std::vector<int> drifted;
  for (int w = 0; w < windows(); ++w) {
    if (drift_[std::size_t(w)] > 1.0) drifted.push_back(w);
  }
  const auto count = std::min(std::ptrdiff_t(limit), std::ptrdiff_t(drifted.size()));
  std::partial_sort(drifted.begin(), drifted.begin() + count, drifted.end(), [&](int a, int b) {
    return std::pair(-drift_[std::size_t(a)], a) < std::pair(-drift_[std::size_t(b)], b);
  });
  drifted.resize(std::size_t(count));
  for (const int i : drifted) {
    Window& w = windows_[std::size_t(i)];
    const WindowCoordinates to = coordinates(w);
    const VectorXd delta = moves(w, to);
    w.values = w.values.retract({delta.data(), std::size_t(delta.size())});
    w.point = to;
    put(i);
    drift_[std::size_t(i)] = 0.0;
    result.variables += w.values.size();
    if (i != result.window) result.relinearized.push_back(i);
  }
  if (drifted.empty()) return false;
  result.merges += refresh();
  result.step_sigma = std::max(result.step_sigma, solve());
  ++result.steps;
  return true;
}

int IncrementalQr::add(const FactorGraph& factors, const Values& new_values,
                       const FactorGraph& removable, bool hold_back) {
  const int window = windows();
  windows_.push_back(make_window(factors, new_values, removable));
  drift_.push_back(0.0);
  Window& w = windows_.back();
  w.removed = hold_back;
  if (w.chain < 0) loose_.push_back(window);
  put(window);
  if (w.chain >= 0) chains_[std::size_t(w.chain)].last = w.point.last;
  return window;
}

void IncrementalQr::append(const FactorGraph& factors, const Values& new_values,
                           const FactorGraph& removable, bool hold_back) {
  add(factors, new_values, removable, hold_back);
}

UpdateResult IncrementalQr::update(const FactorGraph& factors, const Values& new_values,
                                   const FactorGraph& removable, bool hold_back) {
  UpdateResult result;
  result.window = add(factors, new_values, removable, hold_back);
  result.variables = windows_.back().values.size();
  result.merges = refresh();
  result.step_sigma = solve();
  result.steps = 1;
  if (windows() <= options_.eager_windows) {
    for (int round = 0; round < kRounds; ++round) {
      for (int w = 0; w < windows(); ++w) look(w);
      if (!relinearize(windows(), result)) break;
    }
  } else {
    look_around();
    relinearize(options_.relinearized, result);
  }
  result.largest_drift = *std::max_element(drift_.begin(), drift_.end());
  return result;
}

UpdateResult IncrementalQr::idle() {
  UpdateResult result;
  result.merges = refresh();
  result.step_sigma = solve();
  result.steps = 1;
  for (int w = 0; w < windows(); ++w) look(w);
  relinearize(windows(), result);
  for (int w = 0; w < windows(); ++w) look(w);
  if (windows() > 0) result.largest_drift = *std::max_element(drift_.begin(), drift_.end());
  return result;
}

void IncrementalQr::remove(int window) {
  windows_[std::size_t(window)].removed = true;
  put(window);
  refresh();
  solve();
}

void IncrementalQr::restore(int window) {
  windows_[std::size_t(window)].removed = false;
  put(window);
  refresh();
  solve();
}

Innovation IncrementalQr::innovation(int window) const {
  Window w = windows_[std::size_t(window)];
  if (w.chain < 0) throw std::invalid_argument("a window without nodes has no innovation");
  const CondensedTriangle other = condense(w, w.removed, false);
  const int globals = anchors_.dim();
  CondensedTriangle total{0, 0, 0, RowBlock(0, 1)};
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const TriangleTree& tree = chains_[c].tree;
    const CondensedTriangle root =
        int(c) == w.chain ? tree.root_with(w.leaf, other, globals) : tree.root();
    total = sum(total, without_last(root), globals);
  }
  for (const int l : loose_) total = sum(total, windows_[std::size_t(l)].triangle, globals);
  const double change = root_.squares - total.squares;
  return {std::max(0.0, w.removed ? -change : change), w.elimination.rows(1)};
}

}  // namespace magimu
