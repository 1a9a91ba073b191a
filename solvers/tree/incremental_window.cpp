// SPDX-License-Identifier: BSD-3-Clause
// A window that joins an IncrementalQr: the chain that it continues, what is refused, and how it is
// condensed.
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "graph/checks/not_finite.h"
#include "graph/numerical_error.h"
#include "solvers/tree/incremental_qr.h"

namespace magimu {
namespace {

// Beyond this, sums of squares of several windows might no longer be finite.
constexpr double kLargest = 1e100;

bool is_moderate(const RowBlock& R) { return (R.array().abs() < kLargest).all(); }

template <class Body>
void for_each_factor(const FactorGraph& graph, const Body& body) {
  for (const auto& batch : graph.batches()) {
    for (int i = 0; i < batch->size(); ++i) body(batch->keys(i), batch->types());
  }
}

}  // namespace

// Of a chain; one that is held back counts.
int IncrementalQr::newest_window(int chain) const {
  const bool held = held_.window >= 0 && windows_[std::size_t(held_.window)].chain == chain;
  return held ? held_.window : chains_[std::size_t(chain)].windows.back();
}

bool IncrementalQr::is_finite(const Condensed& condensed) {
  return is_moderate(condensed.triangle.R) && condensed.triangle.squares < kLargest * kLargest &&
         std::ranges::all_of(condensed.nodes,
                             [](const EliminatedNode& n) { return is_moderate(n.R); });
}

// Of a node before the last of its chain.
bool IncrementalQr::is_past(Key key) const {
  return std::ranges::any_of(
      windows_, [&](const Window& w) { return std::ranges::find(w.own, key) != w.own.end(); });
}

void IncrementalQr::refuse_unknown(const std::string& factor, Key key) const {
  const std::string needs = factor + " needs " + to_string(key) + ", which is ";
  if (is_past(key)) {
    throw std::invalid_argument(
        needs +
        "neither new nor a global nor of the last node of a chain: a window can only join nodes of "
        "its own and the node before it; give a graph with such a loop to LevenbergMarquardt, or "
        "all windows of the loop in one update");
  }
  throw std::invalid_argument(needs +
                              "neither known from updates before nor among the new values "
                              "of this one: insert an initial value for it there");
}

int IncrementalQr::find_chain(const FactorGraph& graph, const Values& new_values) const {
  int chain = -1;
  for_each_factor(graph, [&](std::span<const Key> keys, std::span<const VariableType> types) {
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const Key key = keys[k];
      const Values& known = new_values.contains(key) ? new_values : globals_;
      if (known.contains(key)) {
        if (known.slot(key).type == types[k]) continue;
        throw std::invalid_argument(name_of_factor(keys) + " takes " + to_string(key) + " for a " +
                                    to_string(types[k]) + ", but it is a " +
                                    to_string(known.slot(key).type));
      }
      int found = -1;
      for (std::size_t c = 0; c < chains_.size() && !options_.is_global(key); ++c) {
        const Values& last = windows_[std::size_t(newest_window(int(c)))].values;
        if (key.index == chains_[c].last_index && last.contains(key)) found = int(c);
      }
      if (found < 0) refuse_unknown(name_of_factor(keys), key);
      if (chain >= 0 && chain != found) {
        throw std::invalid_argument(name_of_factor(keys) +
                                    " is of another chain than the window's other factors: a "
                                    "window continues one chain");
      }
      chain = found;
    }
  });
  return chain;
}

IncrementalQr::Joining IncrementalQr::make_window(FactorGraph factors, const Values& new_values,
                                                  FactorGraph removable) const {
  const int chain = std::max(find_chain(factors, new_values), find_chain(removable, new_values));
  Joining out;
  Window& w = out.window;
  w.factors = std::move(factors);
  w.removable = std::move(removable);
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
  out.anchors = anchors_;
  out.globals = globals_;
  for (const Values::Slot& s : new_values.slots()) {
    if (!options_.is_global(s.key)) continue;
    out.anchors.insert_from(new_values, s.key);
    out.globals.insert_from(new_values, s.key);
  }
  out.x_globals = VectorXd::Zero(out.anchors.dim());
  out.x_globals.head(x_globals_.size()) = x_globals_;
  w.values = out.globals;
  w.point.globals = out.x_globals;
  if (chain >= 0) {
    const int before = newest_window(chain);
    w.first = chains_[std::size_t(chain)].last_index;
    w.point.first = before == held_.window ? windows_[std::size_t(before)].point.last
                                           : chains_[std::size_t(chain)].last;
    insert_last_node(before, w.point.first, w.values);
  }
  for (const Key key : w.own) w.values.insert_from(new_values, key);
  w.elimination =
      WindowElimination({&w.factors, &w.removable}, w.values, options_.is_global, w.first);
  for (int part = 0; part < 2; ++part) w.rows[part] = w.elimination.rows(std::size_t(part));
  for (const WindowElimination::Variable& v : w.elimination.variables()) {
    if (v.rotation && v.place != WindowElimination::Place::kInner) {
      w.turned.push_back({v.place, v.offset});
    }
  }
  w.point.last = VectorXd::Zero(w.elimination.last_width());
  out.begins_chain = chain < 0 && !w.own.empty();
  w.chain = out.begins_chain ? int(chains_.size()) : chain;
  out.low = low;
  out.high = high;
  return out;
}

// With and without its removable factors where it may turn, linearized once. Throws NumericalError
// where the result is not finite.
void IncrementalQr::condense(Joining& joining, bool hold_back) const {
  Window& w = joining.window;
  const auto linearized =
      w.elimination.linearize({&w.factors, &w.removable}, {true, true}, w.values);
  const auto condensed = [&](bool with_removable) {
    Condensed out;
    out.triangle = w.elimination.condense(linearized, {true, with_removable}, w.point, &out.nodes);
    if (is_finite(out)) return out;
    std::optional<NotFinite> found = find_not_finite(w.factors, w.values);
    if (!found) found = find_not_finite(w.removable, w.values);
    throw NumericalError(found ? found->what + " is not a finite number"
                               : "the numbers of a window are too large");
  };
  joining.condensed = condensed(!hold_back);
  if (hold_back) joining.otherwise = condensed(true);
}

// Nothing can fail from here on.
int IncrementalQr::join(Joining joining, bool hold_back) {
  put_held(false);
  const int window = windows();
  const int before =
      joining.window.chain >= 0 && !joining.begins_chain ? newest_window(joining.window.chain) : -1;
  anchors_ = std::move(joining.anchors);
  globals_ = std::move(joining.globals);
  x_globals_ = std::move(joining.x_globals);
  windows_.push_back(std::move(joining.window));
  drift_.push_back(0.0);
  Window& w = windows_.back();
  w.removed = hold_back;
  if (w.chain < 0) loose_.push_back(window);
  if (joining.begins_chain) {
    chains_.emplace_back();
    chains_.back().first_index = joining.low;
  }
  if (w.chain >= 0) chains_[std::size_t(w.chain)].last_index = joining.high;
  if (hold_back && w.chain >= 0 && !joining.begins_chain) {
    held_ = {window, std::move(joining.condensed.triangle)};
  } else {
    put(window, std::move(joining.condensed));
    if (w.chain >= 0) chains_[std::size_t(w.chain)].last = w.point.last;
  }
  w.otherwise = std::move(joining.otherwise);
  if (before >= 0 && held_.window < 0) sleep(before);  // of a chain that has waited
  return window;
}

IncrementalQr::Condensed IncrementalQr::condense(const Window& w, bool with_removable) const {
  const std::vector<bool> used{true, with_removable};
  Condensed out;
  out.triangle =
      w.elimination.condense(w.elimination.linearize({&w.factors, &w.removable}, used, w.values),
                             used, w.point, &out.nodes);
  return out;
}

}  // namespace magimu
