// SPDX-License-Identifier: BSD-3-Clause
#include "graph/factor_graph.h"

#include "graph/linear_system.h"

namespace magimu {

FactorGraph::FactorGraph(const FactorGraph& other) : index_(other.index_) {
  for (const auto& batch : other.batches_) batches_.push_back(batch->clone());
}

FactorGraph& FactorGraph::operator=(const FactorGraph& other) {
  FactorGraph copy(other);
  return *this = std::move(copy);
}

void FactorGraph::add_batch(std::unique_ptr<FactorBatch> batch) {
  for (int i = 0; i < batch->size(); ++i) check_keys(batch->keys(i));
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
      if (keys[i] == keys[j]) {
        throw std::invalid_argument("a factor names variable " + to_string(keys[i]) +
                                    " twice; its variables must differ");
      }
    }
  }
}

}  // namespace magimu
