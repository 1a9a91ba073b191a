// SPDX-License-Identifier: BSD-3-Clause
#include "graph/linear_system.h"

#include <algorithm>

#include "graph/parallel.h"
#include "graph/slot_finder.h"

namespace magimu {
namespace {

constexpr int kChunk = 512;  // factors linearized by one task

}  // namespace

ResolvedKeys resolve(const FactorBatch& batch, const Values& values, std::vector<char>& used) {
  const auto types = batch.types();
  const std::size_t n = types.size();
  ResolvedKeys out;
  out.stored.resize(std::size_t(batch.size()) * n);
  out.tangent.resize(out.stored.size());
  SlotFinder finder(values, n);
  std::size_t at = 0;
  for (int i = 0; i < batch.size(); ++i) {
    const auto keys = batch.keys(i);
    for (std::size_t j = 0; j < n; ++j, ++at) {
      const int found = finder.find(j, keys[j]);
      const Values::Slot& slot =
          found < 0 ? values.slot(keys[j]) : values.slots()[std::size_t(found)];
      if (!(slot.type == types[j])) {
        throw std::invalid_argument("a factor takes variable " + to_string(keys[j]) + " for a " +
                                    to_string(types[j]) + ", but Values holds a " +
                                    to_string(slot.type));
      }
      out.stored[at] = slot.stored;
      out.tangent[at] = slot.tangent;
      used[std::size_t(slot.tangent)] = 1;
    }
  }
  return out;
}

LinearSystem::LinearSystem(const FactorGraph& graph, const Values& values) : cols_(values.dim()) {
  std::vector<char> used(std::size_t(cols_), 0);
  int rows = 0, entries = 0;
  for (const auto& batch : graph.batches()) {
    parts_.push_back({batch.get(), resolve(*batch, values, used), rows, entries});
    row_blocks_.push_back({rows, entries, batch->size(), batch->rows(), batch->columns()});
    rows += batch->size() * batch->rows();
    entries += batch->size() * batch->rows() * batch->columns();
  }
  for (const Values::Slot& slot : values.slots()) {
    if (used[std::size_t(slot.tangent)] == 0) {
      throw std::invalid_argument("variable " + to_string(slot.key) +
                                  " has no factor; add one (a prior, say) or leave it out");
    }
    variable_start_.push_back(slot.tangent);
  }
  variable_start_.push_back(cols_);
  row_start_.resize(std::size_t(rows) + 1);
  row_start_.back() = entries;
  column_.resize(entries);
  value_.resize(entries);
  residual_.resize(rows);
  sum_over_chunks([this](const Part& part, int begin, int end) {
    find_columns(part, begin, end);
    return 0.0;
  });
}

// Every row of a factor has the same columns.
void LinearSystem::find_columns(const Part& part, int begin, int end) {
  const auto types = part.batch->types();
  const int rows = part.batch->rows(), columns = part.batch->columns();
  for (int i = begin; i < end; ++i) {
    const int first = part.first_entry + i * rows * columns;
    int* const own = column_.data() + first;
    int* next = own;
    for (std::size_t j = 0; j < types.size(); ++j) {
      const int tangent = part.keys.tangent[std::size_t(i) * types.size() + j];
      for (int c = 0; c < types[j].tangent(); ++c) *next++ = tangent + c;
    }
    for (int r = 0; r < rows; ++r) {
      if (r > 0) std::copy_n(own, columns, own + r * columns);
      row_start_[std::size_t(part.first_row + i * rows + r)] = first + r * columns;
    }
  }
}

template <class Body>
double LinearSystem::sum_over_chunks(const Body& body) const {
  struct Chunk {
    const Part* part;
    int begin, end;
  };
  std::vector<Chunk> chunks;
  for (const Part& part : parts_) {
    for (int i = 0; i < part.batch->size(); i += kChunk) {
      chunks.push_back({&part, i, std::min(i + kChunk, part.batch->size())});
    }
  }
  std::vector<double> costs(chunks.size(), 0.0);
  parallel::for_each(chunks.size(), [&](std::size_t i) {
    costs[i] = body(*chunks[i].part, chunks[i].begin, chunks[i].end);
  });
  double sum = 0.0;
  for (const double c : costs) sum += c;
  return sum;
}

double LinearSystem::linearize(const Values& values) {
  return sum_over_chunks([&](const Part& p, int begin, int end) {
    const int rows = p.batch->rows(), size = rows * p.batch->columns();
    return p.batch->linearize(values.data(), p.keys, begin, end,
                              residual_.data() + p.first_row + begin * rows,
                              value_.data() + p.first_entry + begin * size);
  });
}

double LinearSystem::cost(const Values& values) const {
  return sum_over_chunks([&](const Part& p, int begin, int end) {
    return p.batch->cost(values.data(), p.keys, begin, end, nullptr);
  });
}

VectorXd LinearSystem::whitened_residuals(const Values& values) const {
  VectorXd out(rows());
  sum_over_chunks([&](const Part& p, int begin, int end) {
    return p.batch->cost(values.data(), p.keys, begin, end,
                         out.data() + p.first_row + begin * p.batch->rows());
  });
  return out;
}

// body(rows, columns, first row, the columns' indices, the entries) for each factor in turn.
template <class Body>
void LinearSystem::for_each_factor(const Body& body) const {
  for (const RowBlocks& b : row_blocks_) {
    for (int i = 0; i < b.count; ++i) {
      const int entry = b.first_entry + i * b.rows * b.columns;
      body(b.rows, b.columns, b.first_row + i * b.rows, column_.data() + entry,
           value_.data() + entry);
    }
  }
}

VectorXd LinearSystem::gradient() const {
  VectorXd g = VectorXd::Zero(cols_), sum(cols_);
  for_each_factor([&](int rows, int columns, int row, const int* column, const double* value) {
    for (int c = 0; c < columns; ++c) sum[c] = 0.0;
    for (int r = 0; r < rows; ++r, value += columns) {
      const double x = residual_[row + r];
      for (int c = 0; c < columns; ++c) sum[c] += value[c] * x;
    }
    for (int c = 0; c < columns; ++c) g[column[c]] += sum[c];
  });
  return g;
}

VectorXd LinearSystem::multiply(const VectorXd& x) const {
  VectorXd y(rows()), part(cols_);
  for_each_factor([&](int rows, int columns, int row, const int* column, const double* value) {
    for (int c = 0; c < columns; ++c) part[c] = x[column[c]];
    for (int r = 0; r < rows; ++r, value += columns) {
      y[row + r] = Eigen::Map<const VectorXd>(value, columns).dot(part.head(columns));
    }
  });
  return y;
}

VectorXd LinearSystem::squared_column_norms() const {
  VectorXd n = VectorXd::Zero(cols_), sum(cols_);
  for_each_factor([&](int rows, int columns, int, const int* column, const double* value) {
    for (int c = 0; c < columns; ++c) sum[c] = 0.0;
    for (int r = 0; r < rows; ++r, value += columns) {
      for (int c = 0; c < columns; ++c) sum[c] += value[c] * value[c];
    }
    for (int c = 0; c < columns; ++c) n[column[c]] += sum[c];
  });
  return n;
}

}  // namespace magimu
