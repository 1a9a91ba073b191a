// SPDX-License-Identifier: BSD-3-Clause
// Where the window engine keeps its values: node by node, lanes side by side.

#include <algorithm>

#include "solvers/lanes/window_engine.h"

#include "graph/parallel.h"

namespace magimu {

using namespace lanes;

void WindowEngine::load(const Values& values) {
  const std::span<const double> data = values.data();
  const std::size_t per_node = layout_.node.size(), stored = std::size_t(layout_.stored);
  const auto put = [&](int node, double* to) {
    for (std::size_t k = 0; k < per_node; ++k) {
      const Values::Slot& s =
          layout_values_.slots()[std::size_t(layout_.slots[std::size_t(node) * per_node + k])];
      for (int i = 0; i < s.type.stored(); ++i) {
        to[std::size_t(layout_.node[k].stored + i) * lanes_] = data[std::size_t(s.stored + i)];
      }
    }
  };
  current_ = condensed_ = 0;
  parallel::for_each(groups_.size(), [&](std::size_t g) {
    const Layout::Group& group = layout_.groups[g];
    for (std::size_t lane = 0; lane < lanes_; ++lane) {
      const int own = group.windows[lane];
      const Layout::Window& w = layout_.windows[std::size_t(own < 0 ? group.windows[0] : own)];
      for (const int set : {0, 1}) {
        double* nodes = groups_[g].nodes[set] + lane;
        put(w.first, groups_[g].left[set].data() + lane);
        for (int step = 0; step <= group.steps; ++step) {
          const int node = std::max(w.first, w.last - (group.steps - step));
          put(node, nodes + std::size_t(step) * stored * lanes_);
        }
      }
    }
  });
  for (int s = 0; s < values.size(); ++s) {
    const Layout::Variable& v = layout_.variables[std::size_t(s)];
    if (v.node >= 0) continue;
    const Values::Slot& slot = layout_values_.slots()[std::size_t(s)];
    for (int i = 0; i < slot.type.stored(); ++i) {
      for (std::size_t lane = 0; lane < lanes_; ++lane) {
        globals_[0][std::size_t(v.stored + i) * lanes_ + lane] = data[std::size_t(slot.stored + i)];
      }
    }
  }
}

void WindowEngine::store(Values& values) const {
  std::vector<double> data(values.data().begin(), values.data().end());
  const std::size_t per_node = layout_.node.size(), stored = std::size_t(layout_.stored);
  for (std::size_t s = 0; s < layout_.variables.size(); ++s) {
    if (layout_.variables[s].node >= 0) continue;
    const Values::Slot& slot = layout_values_.slots()[s];
    for (int i = 0; i < slot.type.stored(); ++i) {
      data[std::size_t(slot.stored + i)] =
          globals_[current_][std::size_t(layout_.variables[s].stored + i) * lanes_];
    }
  }
  for (const Layout::Window& w : layout_.windows) {
    const Group& group = groups_[std::size_t(w.group)];
    for (int node = w.first; node <= w.last; ++node) {
      const double* from =
          node == w.first
              ? group.left[current_].data()
              : group.nodes[current_] + std::size_t(layout_.step(w, node)) * stored * lanes_;
      for (std::size_t k = 0; k < per_node; ++k) {
        const Values::Slot& s =
            layout_values_.slots()[std::size_t(layout_.slots[std::size_t(node) * per_node + k])];
        for (int i = 0; i < s.type.stored(); ++i) {
          data[std::size_t(s.stored + i)] =
              from[std::size_t(layout_.node[k].stored + i) * lanes_ + std::size_t(w.lane)];
        }
      }
    }
  }
  values.assign(data);
}

void WindowEngine::move_boundaries() {
  const std::size_t d = std::size_t(layout_.d), stored = std::size_t(layout_.stored);
  std::vector<double> x(stored), moved(stored);
  const auto move = [&](const double* from, const double* delta, std::size_t lane, double* to) {
    for (std::size_t i = 0; i < stored; ++i) x[i] = from[i * lanes_ + lane];
    for (const NodeVariable& v : layout_.node) {
      const VariableType type =
          v.rotation ? VariableTraits<Rot3>::type() : VariableType{'V', std::uint16_t(v.size), 1};
      retract(type, x.data() + v.stored, delta + v.tangent, moved.data() + v.stored);
    }
    for (std::size_t i = 0; i < stored; ++i) to[i * lanes_ + lane] = moved[i];
  };
  for (std::size_t w = 0; w < layout_.windows.size(); ++w) {
    const Layout::Window& window = layout_.windows[w];
    Group& group = groups_[std::size_t(window.group)];
    const auto lane = std::size_t(window.lane);
    const double* left = chain_->delta(chain_->boundary_of(int(w)));
    const double* right = left + d;
    for (std::size_t i = 0; i < d; ++i) {
      group.delta_left[i * lanes_ + lane] = left[i];
      group.delta_right[i * lanes_ + lane] = right[i];
    }
    const std::size_t end =
        std::size_t(layout_.groups[std::size_t(window.group)].steps) * stored * lanes_;
    move(group.left[current_].data(), left, lane, group.left[1 - current_].data());
    move(group.nodes[current_] + end, right, lane, group.nodes[1 - current_] + end);
  }
  for (std::size_t s = 0; s < layout_.variables.size(); ++s) {
    const Layout::Variable& v = layout_.variables[s];
    if (v.node >= 0) continue;
    const VariableType type = layout_values_.slots()[s].type;
    x.resize(std::size_t(type.stored()));
    moved.resize(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = globals_[current_][(std::size_t(v.stored) + i) * lanes_];
    }
    retract(type, x.data(), chain_->delta_globals().data() + v.tangent, moved.data());
    for (std::size_t i = 0; i < x.size() * lanes_; ++i) {
      globals_[1 - current_][std::size_t(v.stored) * lanes_ + i] = moved[i / lanes_];
    }
  }
}

}  // namespace magimu
