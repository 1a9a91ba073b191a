// SPDX-License-Identifier: BSD-3-Clause
#include "graph/linear_system.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace magimu {
namespace {

constexpr int kChunk = 512;  // factors linearized by one task

const Values::Slot& slot_of(Key key, VariableType type, const Values& values) {
  const Values::Slot& slot = values.slot(key);
  if (!(slot.type == type)) {
    throw std::invalid_argument("a factor takes variable " + to_string(key) + " for a " +
                                to_string(type) + ", but Values holds a " + to_string(slot.type));
  }
  return slot;
}

ResolvedKeys resolve(const FactorBatch& batch, const Values& values, std::vector<char>& used) {
  ResolvedKeys out;
  const auto types = batch.types();
  const std::size_t n = types.size();
  out.stored.resize(std::size_t(batch.size()) * n);
  out.tangent.resize(out.stored.size());
  std::span<const Key> before;
  for (int i = 0; i < batch.size(); ++i) {
    const auto keys = batch.keys(i);
    const std::size_t own = std::size_t(i) * n;
    for (std::size_t j = 0; j < n; ++j) {
      if (i > 0 && keys[j] == before[j]) {  // looked up before: most often a parameter
        out.stored[own + j] = out.stored[own + j - n];
        out.tangent[own + j] = out.tangent[own + j - n];
        continue;
      }
      const Values::Slot& slot = slot_of(keys[j], types[j], values);
      out.stored[own + j] = slot.stored;
      out.tangent[own + j] = slot.tangent;
      used[std::size_t(slot.tangent)] = 1;
    }
    before = keys;
  }
  return out;
}

}  // namespace

LinearSystem::LinearSystem(const FactorGraph& graph, const Values& values) : cols_(values.dim()) {
  std::size_t rows = 0, entries = 0;
  for (const auto& batch : graph.batches()) {
    const auto own = std::size_t(batch->size()) * std::size_t(batch->rows());
    rows += own;
    entries += own * std::size_t(batch->columns());
  }
  row_start_.reserve(rows + 1);
  column_.reserve(entries);
  row_start_.push_back(0);
  std::vector<char> used(std::size_t(cols_), 0);
  for (const auto& batch : graph.batches()) {
    parts_.push_back({batch.get(), resolve(*batch, values, used), int(row_start_.size()) - 1,
                      int(column_.size())});
    row_blocks_.push_back({parts_.back().first_row, parts_.back().first_entry, batch->size(),
                           batch->rows(), batch->columns()});
    const auto types = batch->types();
    const ResolvedKeys& keys = parts_.back().keys;
    for (int i = 0; i < batch->size(); ++i) {
      for (std::size_t j = 0; j < types.size(); ++j) {
        const int first = keys.tangent[std::size_t(i) * types.size() + j];
        for (int c = 0; c < types[j].tangent(); ++c) column_.push_back(first + c);
      }
      row_start_.push_back(int(column_.size()));
      for (int row = 1; row < batch->rows(); ++row) {  // the same columns
        const std::size_t end = column_.size(), n = std::size_t(batch->columns());
        column_.resize(end + n);
        std::copy_n(column_.begin() + std::ptrdiff_t(end - n), n,
                    column_.begin() + std::ptrdiff_t(end));
        row_start_.push_back(int(column_.size()));
      }
    }
  }
  for (const Values::Slot& slot : values.slots()) {
    if (used[std::size_t(slot.tangent)] == 0) {
      throw std::invalid_argument("variable " + to_string(slot.key) +
                                  " has no factor; add one (a prior, say) or leave it out");
    }
    variable_start_.push_back(slot.tangent);
  }
  variable_start_.push_back(cols_);
  value_.resize(column_.size());
  residual_.resize(Eigen::Index(rows));
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
  tbb::parallel_for(std::size_t(0), chunks.size(), [&](std::size_t i) {
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
      const auto entry =
          std::size_t(b.first_entry) + std::size_t(i) * std::size_t(b.rows * b.columns);
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
