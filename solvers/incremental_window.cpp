// SPDX-License-Identifier: BSD-3-Clause
// A window that joins an IncrementalQr: the chain that it continues, what is refused, and how it is
// condensed.
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "solvers/incremental_qr.h"

namespace magimu {
namespace {

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

IncrementalQr::Window IncrementalQr::make_window(FactorGraph factors, const Values& new_values,
                                                 FactorGraph removable) {
  const int chain = std::max(find_chain(factors, new_values), find_chain(removable, new_values));
  Window w;
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

IncrementalQr::Condensed IncrementalQr::condense(const Window& w, bool with_removable) const {
  const std::vector<bool> used{true, with_removable};
  Condensed out;
  out.triangle =
      w.elimination.condense(w.elimination.linearize({&w.factors, &w.removable}, used, w.values),
                             used, w.point, &out.nodes);
  return out;
}

// With and without its removable factors, linearized once.
void IncrementalQr::hold(int window) {
  Window& w = windows_[std::size_t(window)];
  const auto linearized =
      w.elimination.linearize({&w.factors, &w.removable}, {true, true}, w.values);
  held_ = {window, w.elimination.condense(linearized, {true, false}, w.point, nullptr)};
  Condensed with;
  with.triangle = w.elimination.condense(linearized, {true, true}, w.point, &with.nodes);
  w.otherwise = std::move(with);
}

}  // namespace magimu
