// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/window_program.h"

#include <algorithm>
#include <utility>

#include "graph/parallel.h"

namespace magimu::lanes {

Program::Program(const FactorGraph& graph, const Layout& layout, Isa isa)
    : graph_(graph),
      layout_(layout),
      isa_(isa),
      lanes_(std::size_t(lanes_of(isa))),
      groups_(layout.groups.size()) {
  std::vector<Part> parts(graph.batches().size());
  parallel::for_each(parts.size(), [&](std::size_t b) { parts[b] = assign(b); });
  for (Part& part : parts) {
    for (auto& pattern : part.patterns) {
      const Pattern& p = pattern->pattern;
      jacobian_doubles_ = std::max(jacobian_doubles_, p.rows * (p.columns + 1));
      patterns_.push_back(std::move(pattern));
    }
    global_factors_.insert(global_factors_.end(), part.global_factors.begin(),
                           part.global_factors.end());
  }
  parallel::for_each(groups_.size(), [&](std::size_t g) {
    std::vector<const Layer*> layers;
    for (const Part& part : parts) {
      for (const Layer& layer : part.layers[g]) layers.push_back(&layer);
    }
    fill(layers, layout.groups[g], groups_[g]);
  });
  for (const Group& group : groups_) rows_ = std::max(rows_, group.rows);
}

Program::Part Program::assign(std::size_t b) const {
  const FactorBatch& batch = *graph_.batches()[b];
  const std::size_t n = batch.types().size();
  Part part;
  part.layers.resize(layout_.groups.size());
  std::vector<int> code(n, -1);
  const OwnPattern* pattern = nullptr;
  const auto find_pattern = [&](const int* slots) {
    for (const auto& known : part.patterns) {
      if (known->code == code) return known.get();
    }
    part.patterns.push_back(
        std::make_unique<OwnPattern>(batch, layout_.noise[b], code, slots, layout_, isa_));
    return part.patterns.back().get();
  };
  for (int f = 0; f < batch.size(); ++f) {
    const int* slots = layout_.factor[b].data() + std::size_t(f) * n;
    int low = layout_.nodes();
    for (std::size_t k = 0; k < n; ++k) {
      const int node = layout_.variables[std::size_t(slots[k])].node;
      if (node >= 0) low = std::min(low, node);
    }
    if (low == layout_.nodes()) {
      part.global_factors.push_back({int(b), f});
      continue;
    }
    const Layout::Window& w = layout_.windows[std::size_t(layout_.window_of[std::size_t(low)])];
    bool as_before = true;
    for (std::size_t k = 0; k < n; ++k) {
      const Layout::Variable& v = layout_.variables[std::size_t(slots[k])];
      const Place place = v.node < 0          ? Place::kGlobal
                          : v.node > low      ? Place::kNext
                          : v.node == w.first ? Place::kLeft
                                              : Place::kOwn;
      const int at = int(place) + 4 * v.stored;
      as_before &= std::exchange(code[k], at) == at;
    }
    if (!as_before) pattern = find_pattern(slots);
    std::vector<Layer>& own = part.layers[std::size_t(w.group)];
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
  return part;
}

void Program::fill(const std::vector<const Layer*>& layers, const Layout::Group& lanes,
                   Group& group) const {
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
    for (const Layer* layer : layers) {
      if (any(*layer, step) < 0) continue;
      ++calls;
      doubles += std::size_t(layer->pattern->pattern.doubles) * lanes_;
      rows += layer->pattern->pattern.rows;
    }
    group.rows = std::max(group.rows, rows);
  }
  group.first_call.push_back(int(calls));
  group.data = AlignedBuffer(doubles, AlignedBuffer::Fill::kNone);  // copy() fills all of it
  group.present = AlignedBuffer(calls * lanes_);
  group.factors.reserve(calls * lanes_);
  group.calls.reserve(calls);
  double* data = group.data.data();
  std::vector<int> chosen(lanes_);
  for (int step = 0; step <= lanes.steps; ++step) {
    for (const Layer* layer : layers) {
      const int some = any(*layer, step);
      if (some < 0) continue;
      const OwnPattern& own = *layer->pattern;
      double* present = group.present.data() + group.calls.size() * lanes_;
      bool all = true;
      for (std::size_t lane = 0; lane < lanes_; ++lane) {
        const int f = layer->factors[std::size_t(step) * lanes_ + lane];
        group.factors.push_back(f);
        all &= f >= 0;
        present[lane] = f >= 0 ? 1.0 : 0.0;
        // A lane without a factor has another's text, for finite numbers.
        chosen[lane] = f >= 0 ? f : some;
      }
      if (own.pattern.doubles > 0) own.copy(chosen, data);
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
