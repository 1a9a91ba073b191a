// SPDX-License-Identifier: BSD-3-Clause
// What the lanes of each group do at each step: which factors are linearized, from which variables,
// and where their products go. Worked out once for an optimization; measurements are copied into
// the order in which they are read.
#pragma once

#include <memory>
#include <vector>

#include "solvers/lanes/window_pattern.h"

namespace magimu::lanes {

class Program {
 public:
  Program(const FactorGraph& graph, const Layout& layout, Isa isa);

  struct Group {
    std::vector<Call> calls;
    std::vector<int> first_call;  // of each step, and the end
    AlignedBuffer absent, data;   // Sweep::absent; of all calls
    AlignedBuffer present;        // of calls that lack factors
    std::vector<int> factors;     // of calls without lane code, one a lane
    int rows = 0;                 // of the factors of a step, at most
  };
  const std::vector<Group>& groups() const { return groups_; }
  // Factors of globals alone.
  struct GlobalFactor {
    int batch, factor;
  };
  const std::vector<GlobalFactor>& global_factors() const { return global_factors_; }
  // Doubles of the largest Jacobian of a factor, its residual with it.
  int jacobian_doubles() const { return jacobian_doubles_; }
  // Of the factors of a step, at most.
  int rows() const { return rows_; }

 private:
  // The factors of one pattern in one group: one at each step and lane, or -1.
  struct Layer {
    const OwnPattern* pattern;
    std::vector<int> factors;
  };
  // What comes of one batch.
  struct Part {
    std::vector<std::unique_ptr<OwnPattern>> patterns;
    std::vector<std::vector<Layer>> layers;  // of each group
    std::vector<GlobalFactor> global_factors;
  };
  Part assign(std::size_t batch) const;
  void fill(const std::vector<const Layer*>& layers, const Layout::Group& lanes,
            Group& group) const;

  const FactorGraph& graph_;
  const Layout& layout_;
  Isa isa_;
  std::size_t lanes_;
  std::vector<std::unique_ptr<OwnPattern>> patterns_;
  std::vector<Group> groups_;
  std::vector<GlobalFactor> global_factors_;
  int jacobian_doubles_ = 0, rows_ = 0;
};

}  // namespace magimu::lanes
