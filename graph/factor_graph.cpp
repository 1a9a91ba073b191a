// SPDX-License-Identifier: BSD-3-Clause
#include "graph/factor_graph.h"

#include "graph/linear_system.h"

namespace magimu {
namespace {

[[noreturn]] void throw_twice(Key key) {
  throw std::invalid_argument("a factor names variable " + to_string(key) +
                              " twice; its variables must differ");
}

// before: the keys of another factor, which are all different. What has not changed needs no
// second look: factors may share hundreds of keys.
void check_changed(std::span<const Key> keys, std::span<const Key> before) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == before[i]) continue;
    for (std::size_t j = 0; j < keys.size(); ++j) {
      if (j != i && keys[i] == keys[j]) throw_twice(keys[i]);
    }
  }
}

}  // namespace

FactorGraph::FactorGraph(const FactorGraph& other) : index_(other.index_) {
  for (const auto& batch : other.batches_) batches_.push_back(batch->clone());
}

FactorGraph& FactorGraph::operator=(const FactorGraph& other) {
  FactorGraph copy(other);
  return *this = std::move(copy);
}

void FactorGraph::add_batch(std::unique_ptr<FactorBatch> batch) {
  if (batch->size() > 0) check_keys(batch->keys(0));
  for (int i = 1; i < batch->size(); ++i) check_changed(batch->keys(i), batch->keys(i - 1));
  batches_.push_back(std::move(batch));
}

int FactorGraph::size() const {
  int n = 0;
  for (const auto& batch : batches_) n += batch->size();
  return n;
}

double FactorGraph::cost(const Values& values) const {
  return LinearSystem(*this, values).cost(values);
}

void FactorGraph::check_keys(std::span<const Key> keys) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (keys[i] == keys[j]) throw_twice(keys[i]);
    }
  }
}

}  // namespace magimu
