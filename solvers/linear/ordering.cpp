// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/linear/ordering.h"

#include <cmath>

namespace magimu {

std::vector<int> global_columns(const LinearSystem& system) {
  std::vector<int> count(std::size_t(system.cols()), 0);
  for (const int c : system.column()) ++count[std::size_t(c)];
  // A pose has some dozen rows however long the recording; a global has a fixed share of them all.
  const int many = std::max(64, int(10.0 * std::sqrt(double(system.rows()))));
  for (int& c : count) c = c > many ? 1 : 0;
  return count;
}

}  // namespace magimu
