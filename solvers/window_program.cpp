// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/window_program.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

namespace magimu::lanes {
namespace {

// Where a column of a factor belongs.
struct Column {
  enum Block { kOwnNode, kNextNode, kBorder } block;
  int index;
  bool operator<=(const Column& o) const {
    return block < o.block || (block == o.block && index <= o.index);
  }
};

int target(const Column& i, const Column& j, int d, int b) {
  const bool border = j.block == Column::kBorder;
  if (i.block == Column::kBorder) return border_at(d, b) + block_index(i.index, j.index, b);
  if (i.block == Column::kNextNode) {
    return border ? next_border_at(d, b) + i.index * b + j.index
                  : next_at(d) + i.index * d + j.index;
  }
  if (border) return own_border_at(d, b) + i.index * b + j.index;
  return (j.block == Column::kOwnNode ? own_at(d) : coupling_at(d)) + i.index * d + j.index;
}

// Products of columns i, ..., side by side, with all later ones: the columns that are side by side
// in one block of the state, too, together. A product below the diagonal has its place, and no
// meaning.
std::vector<Products> products_of(const std::vector<Column>& columns, int d, int b) {
  const auto n = int(columns.size());
  const auto at = [&](int i) { return columns[std::size_t(i)]; };
  const auto together = [&](int i, int j) {
    const bool same_rows = at(i).block != Column::kBorder || at(i).index / 4 == at(j).index / 4;
    return at(j).block == at(i).block && at(j).index == at(i).index + j - i && same_rows;
  };
  std::vector<Products> out;
  for (int i = 0, rows = 0; i < n; i += rows) {
    rows = 1;
    while (rows < Products::kMaxRows && i + rows < n && together(i, i + rows)) ++rows;
    for (int j = 0; j < n;) {
      if (!(at(i) <= at(j))) {
        ++j;
        continue;
      }
      Products p{i, rows, j, 0, {}};
      for (int r = 0; r < rows; ++r) p.to[r] = target(at(i + r), at(j), d, b);
      while (j < n && at(i) <= at(j) && target(at(i), at(j), d, b) == p.to[0] + (j - p.first)) {
        ++j;
      }
      p.count = j - p.first;
      out.push_back(p);
    }
  }
  return out;
}

bool same_whitening(const FactorBatch& batch) {
  const auto size = std::size_t(batch.rows() * batch.rows());
  for (int f = 1; f < batch.size(); ++f) {
    if (!std::equal(batch.whitening(f), batch.whitening(f) + size, batch.whitening(0)))
      return false;
  }
  return true;
}

// The diagonal, or the lower triangle row by row.
double* copy_whitening(const FactorBatch& batch, int factor, bool diagonal, double* to,
                       std::size_t lanes) {
  const double* W = batch.whitening(factor);
  for (int r = 0; r < batch.rows(); ++r) {
    for (int k = diagonal ? r : 0; k <= r; ++k, to += lanes) *to = W[k * batch.rows() + r];
  }
  return to;
}

}  // namespace

struct Program::OwnPattern {
  Pattern pattern{};
  std::size_t batch = 0;
  const FactorBatch* factors = nullptr;
  std::vector<int> code;  // place and offset of each key
  std::vector<Source> sources;
  std::vector<Products> products;
  std::vector<int> globals;
  AlignedBuffer whitening;
  // For factors without lane code: stored numbers of each variable; and where they lie when the
  // variables of one factor stand side by side, the same for all.
  std::vector<int> sizes;
  ResolvedKeys keys;

  // The rows of a factor in one lane, the residual last.
  static void linearize(const Pattern& p, int factor, int lane, int lanes, const double* const* x,
                        double* J) {
    const auto& own = *static_cast<const OwnPattern*>(p.context);
    const int stride = p.columns + 1;
    if (factor < 0) {
      for (int i = 0; i < p.rows * stride; ++i) J[i * lanes + lane] = 0.0;
      return;
    }
    thread_local std::vector<double> values, r, rows;
    values.clear();
    for (std::size_t k = 0; k < own.sizes.size(); ++k) {
      for (int i = 0; i < own.sizes[k]; ++i) values.push_back(x[k][i * lanes + lane]);
    }
    r.resize(std::size_t(p.rows));
    rows.resize(std::size_t(p.rows * p.columns));
    own.factors->linearize(values, own.keys, factor, factor + 1, r.data(), rows.data());
    for (int i = 0; i < p.rows; ++i) {
      double* row = J + i * stride * lanes + lane;
      for (int c = 0; c < p.columns; ++c) row[c * lanes] = rows[std::size_t(i * p.columns + c)];
      row[p.columns * lanes] = r[std::size_t(i)];
    }
  }
};

Program::Program(const FactorGraph& graph, const Layout& layout, Isa isa)
    : graph_(graph), layout_(layout), isa_(isa), lanes_(std::size_t(lanes_of(isa))) {
  patterns_of_.resize(graph.batches().size());
  groups_.resize(layout.groups.size());
  std::vector<std::vector<Layer>> layers(layout.groups.size());
  for (std::size_t batch = 0; batch < graph.batches().size(); ++batch) assign(batch, layers);
  tbb::parallel_for(std::size_t(0), groups_.size(),
                    [&](std::size_t g) { fill(layers[g], layout.groups[g], groups_[g]); });
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
  patterns_.push_back(make_pattern(batch, code, slots));
  patterns_of_[batch].push_back(int(patterns_.size()) - 1);
  return int(patterns_.size()) - 1;
}

std::shared_ptr<Program::OwnPattern> Program::make_pattern(std::size_t b,
                                                           const std::vector<int>& code,
                                                           const int* slots) {
  auto own = std::make_shared<OwnPattern>();
  const FactorBatch& batch = *graph_.batches()[b];
  Pattern& p = own->pattern;
  own->batch = b;
  own->factors = &batch;
  own->code = code;
  p.text = batch.lane_text(isa_);
  p.rows = batch.rows();
  p.columns = batch.columns();
  const int d = layout_.d, border = layout_.b();
  std::vector<Column> columns;
  int stored = 0;
  for (std::size_t k = 0; k < code.size(); ++k) {
    const Layout::Variable& v = layout_.variables[std::size_t(slots[k])];
    const auto place = Place(code[k] % 4);
    const bool is_linear = k + batch.linear_at().size() >= code.size();
    if (!is_linear || p.text.linearize == nullptr) own->sources.push_back({place, v.stored});
    const VariableType type = batch.types()[k];
    own->keys.stored.push_back(stored);
    own->keys.tangent.push_back(int(columns.size()));
    own->sizes.push_back(type.stored());
    stored += type.stored();
    const auto block = place == Place::kOwn    ? Column::kOwnNode
                       : place == Place::kNext ? Column::kNextNode
                                               : Column::kBorder;
    for (int c = 0; c < type.tangent(); ++c) {
      columns.push_back({block, v.tangent + c + (place == Place::kGlobal ? d : 0)});
    }
  }
  own->sources.push_back({Place::kOwn, -1});
  columns.push_back({Column::kBorder, border - 1});
  own->products = products_of(columns, d, border);
  const std::span<const double> linear = batch.linear_at();
  p.linear = int(linear.size());
  p.at = linear.data();
  for (std::size_t j = code.size() - linear.size(); j < code.size(); ++j) {
    own->globals.push_back(code[j] / 4);
  }
  p.sources = own->sources.data();
  p.products = own->products.data();
  p.n_products = int(own->products.size());
  p.globals = own->globals.data();
  if (p.text.linearize != nullptr) {
    p.diagonal = batch.whitening_is_diagonal();
    const int whitening = p.diagonal ? p.rows : p.rows * (p.rows + 1) / 2;
    p.doubles = p.text.doubles + p.rows * p.linear;
    if (same_whitening(batch)) {
      own->whitening = AlignedBuffer(std::size_t(whitening) * lanes_);
      for (std::size_t lane = 0; lane < lanes_; ++lane) {
        copy_whitening(batch, 0, p.diagonal, own->whitening.data() + lane, lanes_);
      }
      p.whitening = own->whitening.data();
    } else {
      p.doubles += whitening;
    }
  } else {
    // Every factor finds its variables where the first would.
    const std::vector<int> one = own->keys.stored, tangent = own->keys.tangent;
    for (int f = 1; f < batch.size(); ++f) {
      own->keys.stored.insert(own->keys.stored.end(), one.begin(), one.end());
      own->keys.tangent.insert(own->keys.tangent.end(), tangent.begin(), tangent.end());
    }
    p.linearize_one = &OwnPattern::linearize;
    p.context = own.get();
  }
  jacobian_doubles_ = std::max(jacobian_doubles_, p.rows * (p.columns + 1));
  return own;
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
    group.first_call.push_back(int(calls));
    for (const Layer& layer : layers) {
      if (any(layer, step) < 0) continue;
      ++calls;
      doubles += std::size_t(pattern(layer).doubles) * lanes_;
    }
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
        if (own.pattern.doubles > 0) copy(own, f >= 0 ? f : some, data + lane);
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

void Program::copy(const OwnPattern& own, int factor, double* data) const {
  const Pattern& p = own.pattern;
  thread_local std::vector<double> text;
  text.resize(std::size_t(p.text.doubles));
  own.factors->copy_text(factor, text.data());
  for (const double x : text) {
    *data = x;
    data += lanes_;
  }
  if (p.whitening == nullptr) {
    data = copy_whitening(*own.factors, factor, p.diagonal, data, lanes_);
  }
  const double* gain = own.factors->linear_gain(factor);
  for (int i = 0; i < p.rows * p.linear; ++i) {
    *data = gain[i];
    data += lanes_;
  }
}

}  // namespace magimu::lanes
