// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/window_pattern.h"

#include <algorithm>

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

// In a row [own | next | border].
int place_of(const Column& c, int d) {
  return c.index + (c.block == Column::kOwnNode ? 0 : c.block == Column::kNextNode ? d : 2 * d);
}

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

// Of text.add_products.
std::vector<int> sums_of(const std::vector<Column>& columns, int d, int b) {
  std::vector<int> out;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    for (std::size_t j = i; j < columns.size(); ++j) {
      const bool ascending = columns[i] <= columns[j];
      const Column &first = columns[ascending ? i : j], &second = columns[ascending ? j : i];
      out.push_back(target(first, second, d, b));
    }
  }
  return out;
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

OwnPattern::OwnPattern(const FactorBatch& own, const NoiseKinds& noise, std::vector<int> own_code,
                       const int* slots, const Layout& layout, Isa isa)
    : factors(own), code(std::move(own_code)), lanes_(lanes_of(isa)) {
  Pattern& p = pattern;
  p.text = factors.lane_text(isa);
  p.rows = factors.rows();
  p.columns = factors.columns();
  const int d = layout.d, border = layout.b();
  std::vector<Column> at;
  int stored = 0;
  for (std::size_t k = 0; k < code.size(); ++k) {
    const Layout::Variable& v = layout.variables[std::size_t(slots[k])];
    const auto place = Place(code[k] % 4);
    const bool is_linear = k + factors.linear_at().size() >= code.size();
    if (!is_linear || p.text.linearize == nullptr) sources_.push_back({place, v.stored});
    const VariableType type = factors.types()[k];
    keys_.stored.push_back(stored);
    keys_.tangent.push_back(int(at.size()));
    sizes_.push_back(type.stored());
    stored += type.stored();
    const auto block = place == Place::kOwn    ? Column::kOwnNode
                       : place == Place::kNext ? Column::kNextNode
                                               : Column::kBorder;
    for (int c = 0; c < type.tangent(); ++c) {
      at.push_back({block, v.tangent + c + (place == Place::kGlobal ? d : 0)});
    }
  }
  sources_.push_back({Place::kOwn, -1});
  at.push_back({Column::kBorder, border - 1});
  products_ = products_of(at, d, border);
  if (p.text.add_products != nullptr && factors.linear_at().empty()) {
    sums_ = sums_of(at, d, border);
    p.sums = sums_.data();
  }
  for (const Column& c : at) places_.push_back(place_of(c, d));
  const std::span<const double> linear = factors.linear_at();
  p.linear = int(linear.size());
  p.at = linear.data();
  for (std::size_t j = code.size() - linear.size(); j < code.size(); ++j) {
    globals_.push_back(code[j] / 4);
  }
  p.sources = sources_.data();
  p.places = places_.data();
  p.products = products_.data();
  p.n_products = int(products_.size());
  p.globals = globals_.data();
  if (p.text.linearize != nullptr) {
    p.diagonal = noise.diagonal;
    const int numbers = p.diagonal ? p.rows : p.rows * (p.rows + 1) / 2;
    p.doubles = p.text.doubles + p.rows * p.linear;
    if (noise.same) {
      whitening_ = AlignedBuffer(std::size_t(numbers) * std::size_t(lanes_));
      for (std::size_t lane = 0; lane < std::size_t(lanes_); ++lane) {
        copy_whitening(factors, 0, p.diagonal, whitening_.data() + lane, std::size_t(lanes_));
      }
      p.whitening = whitening_.data();
    } else {
      p.doubles += numbers;
    }
  } else {
    // Every factor finds its variables where the first would.
    const std::vector<int> one = keys_.stored, tangent = keys_.tangent;
    for (int f = 1; f < factors.size(); ++f) {
      keys_.stored.insert(keys_.stored.end(), one.begin(), one.end());
      keys_.tangent.insert(keys_.tangent.end(), tangent.begin(), tangent.end());
    }
    p.linearize_one = &linearize;
    p.context = this;
  }
}

void OwnPattern::linearize(const Pattern& p, int factor, int lane, int lanes,
                           const double* const* x, double* J) {
  const auto& own = *static_cast<const OwnPattern*>(p.context);
  const int stride = p.columns + 1;
  if (factor < 0) {
    for (int i = 0; i < p.rows * stride; ++i) J[i * lanes + lane] = 0.0;
    return;
  }
  thread_local std::vector<double> values, r, rows;
  values.clear();
  for (std::size_t k = 0; k < own.sizes_.size(); ++k) {
    for (int i = 0; i < own.sizes_[k]; ++i) values.push_back(x[k][i * lanes + lane]);
  }
  r.resize(std::size_t(p.rows));
  rows.resize(std::size_t(p.rows * p.columns));
  own.factors.linearize(values, own.keys_, factor, factor + 1, r.data(), rows.data());
  for (int i = 0; i < p.rows; ++i) {
    double* row = J + i * stride * lanes + lane;
    for (int c = 0; c < p.columns; ++c) row[c * lanes] = rows[std::size_t(i * p.columns + c)];
    row[p.columns * lanes] = r[std::size_t(i)];
  }
}

void OwnPattern::copy(std::span<const int> chosen, double* data) const {
  const Pattern& p = pattern;
  const std::size_t lanes = chosen.size();
  factors.copy_texts(chosen, data);
  data += std::size_t(p.text.doubles) * lanes;
  if (p.whitening != nullptr && p.linear == 0) return;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    double* to = data + lane;
    if (p.whitening == nullptr) to = copy_whitening(factors, chosen[lane], p.diagonal, to, lanes);
    const double* gain = factors.linear_gain(chosen[lane]);
    for (int i = 0; i < p.rows * p.linear; ++i, to += lanes) *to = gain[i];
  }
}

}  // namespace magimu::lanes
