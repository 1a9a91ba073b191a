// SPDX-License-Identifier: BSD-3-Clause
// How the variables that factors join follow each other as a chain: levels of which each is joined
// to its neighbours only.
#pragma once

#include <span>
#include <vector>

#include "solvers/linear/lists.h"

namespace magimu {

class ChainLevels {
 public:
  // factors: the variables of each one; globals aside. width: degrees of freedom of each variable.
  ChainLevels(const Lists& factors, std::vector<int> width);

  // All variables that are joined to this one, from an end of their chain to the other.
  Lists of(int variable);
  int width(std::span<const int> level) const;

 private:
  Lists levels_from(std::span<const int> start);
  double work(const Lists& levels) const;

  const Lists& variables_in_;  // of each factor
  Lists factors_on_;           // of each variable
  std::vector<int> width_, seen_variable_, seen_factor_;
  int pass_ = 0;
};

}  // namespace magimu
