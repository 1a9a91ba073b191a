// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/window_program.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace magimu::lanes {

Program::Program(const FactorGraph& graph, const Layout& layout, Isa isa)
    : graph_(graph), layout_(layout), isa_(isa), lanes_(std::size_t(lanes_of(isa))) {
  patterns_of_.resize(graph.batches().size());
  groups_.resize(layout.groups.size());
  std::vector<std::vector<Layer>> layers(layout.groups.size());
  for (std::size_t batch = 0; batch < graph.batches().size(); ++batch) assign(batch, layers);
  tbb::parallel_for(std::size_t(0), groups_.size(),
                    [&](std::size_t g) { fill(layers[g], layout.groups[g], groups_[g]); });
  for (const Group& group : groups_) rows_ = std::max(rows_, group.rows);
}

void Program::assign(std::size_t b, std::vector<std::vector<Layer>>& layers) {
  const FactorBatch& batch = *graph_.batches()[b];
  const std::size_t n = batch.types().size();
  std::vector<int> code(n), last;
  int pattern = -1;
  for (int f = 0; f < batch.size(); ++f) {
    const int* slots = layout_.factor[b].data() + std::size_t(f) * n;
    int low = layout_.nodes();
    for (std::size_t k = 0; k < n; ++k) {
      const int node = layout_.variables[std::size_t(slots[k])].node;
      if (node >= 0) low = std::min(low, node);
    }
    if (low == layout_.nodes()) {
      global_factors_.push_back({int(b), f});
      continue;
    }
    const Layout::Window& w = layout_.windows[std::size_t(layout_.window_of[std::size_t(low)])];
    for (std::size_t k = 0; k < n; ++k) {
      const Layout::Variable& v = layout_.variables[std::size_t(slots[k])];
      const Place place = v.node < 0          ? Place::kGlobal
                          : v.node > low      ? Place::kNext
                          : v.node == w.first ? Place::kLeft
                                              : Place::kOwn;
      code[k] = int(place) + 4 * v.stored;
    }
    if (code != last) {
      pattern = pattern_of(b, code, slots);
      last = code;
    }
    std::vector<Layer>& own = layers[std::size_t(w.group)];
    const std::size_t place = std::size_t(layout_.step(w, low)) * lanes_ + std::size_t(w.lane);
    std::size_t layer = 0;  // the first of this pattern that is free there
    while (layer < own.size() &&
           (own[layer].pattern != pattern || own[layer].factors[place] >= 0)) {
      ++layer;
    }
    if (layer == own.size()) {
      const int steps = layout_.groups[std::size_t(w.group)].steps;
      own.push_back({pattern, std::vector<int>((std::size_t(steps) + 1) * lanes_, -1)});
    }
    own[layer].factors[place] = f;
  }
}

int Program::pattern_of(std::size_t batch, const std::vector<int>& code, const int* slots) {
  for (const int p : patterns_of_[batch]) {
    if (patterns_[std::size_t(p)]->code == code) return p;
  }
  patterns_.push_back(
      std::make_unique<OwnPattern>(*graph_.batches()[batch], code, slots, layout_, isa_));
  const Pattern& p = patterns_.back()->pattern;
  jacobian_doubles_ = std::max(jacobian_doubles_, p.rows * (p.columns + 1));
  patterns_of_[batch].push_back(int(patterns_.size()) - 1);
  return int(patterns_.size()) - 1;
}

void Program::fill(const std::vector<Layer>& layers, const Layout::Group& lanes,
                   Group& group) const {
  const auto pattern = [&](const Layer& layer) -> const Pattern& {
    return patterns_[std::size_t(layer.pattern)]->pattern;
  };
  const auto any = [&](const Layer& layer, int step) {
    const auto begin = layer.factors.begin() + std::ptrdiff_t(std::size_t(step) * lanes_);
    const auto it =
        std::find_if(begin, begin + std::ptrdiff_t(lanes_), [](int f) { return f >= 0; });
    return it == begin + std::ptrdiff_t(lanes_) ? -1 : *it;
  };
  // Calls first, then their data: pointers into it need its size.
  std::size_t doubles = 0, calls = 0;
  for (int step = 0; step <= lanes.steps; ++step) {
    int rows = 0;
    group.first_call.push_back(int(calls));
    for (const Layer& layer : layers) {
      if (any(layer, step) < 0) continue;
      ++calls;
      doubles += std::size_t(pattern(layer).doubles) * lanes_;
      rows += pattern(layer).rows;
    }
    group.rows = std::max(group.rows, rows);
  }
  group.first_call.push_back(int(calls));
  group.data = AlignedBuffer(doubles, AlignedBuffer::Fill::kNone);  // copy() fills all of it
  group.present = AlignedBuffer(calls * lanes_);
  group.factors.reserve(calls * lanes_);
  group.calls.reserve(calls);
  double* data = group.data.data();
  for (int step = 0; step <= lanes.steps; ++step) {
    for (const Layer& layer : layers) {
      const int some = any(layer, step);
      if (some < 0) continue;
      const OwnPattern& own = *patterns_[std::size_t(layer.pattern)];
      double* present = group.present.data() + group.calls.size() * lanes_;
      bool all = true;
      for (std::size_t lane = 0; lane < lanes_; ++lane) {
        const int f = layer.factors[std::size_t(step) * lanes_ + lane];
        group.factors.push_back(f);
        all &= f >= 0;
        present[lane] = f >= 0 ? 1.0 : 0.0;
        // A lane without a factor has another's text, for finite numbers.
        if (own.pattern.doubles > 0) own.copy(f >= 0 ? f : some, data + lane);
      }
      const int* factors = group.factors.data() + group.calls.size() * lanes_;
      group.calls.push_back({&own.pattern, data, all ? nullptr : present, factors});
      data += std::size_t(own.pattern.doubles) * lanes_;
    }
  }
  group.absent = AlignedBuffer((std::size_t(lanes.steps) + 1) * lanes_);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    const int w = lanes.windows[lane];
    const int begin = w < 0 ? lanes.steps
                            : layout_.step(layout_.windows[std::size_t(w)],
                                           layout_.windows[std::size_t(w)].first);
    for (int s = 0; s <= begin; ++s) group.absent[std::size_t(s) * lanes_ + lane] = 1.0;
  }
}

}  // namespace magimu::lanes
