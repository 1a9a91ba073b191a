// SPDX-License-Identifier: BSD-3-Clause
#include "apps/version.h"

#include <fmt/format.h>

#include <Eigen/Core>

namespace magimu::apps {

std::string version_text() {
  return fmt::format(
      "magimu {}\ncompiler: {}\nbuild type: {}\nSuiteSparse: {}\nEigen: {}.{}.{}", MAGIMU_VERSION,
      MAGIMU_COMPILER, MAGIMU_BUILD_TYPE,
      MAGIMU_SUITESPARSE ? "yes (SPQR and CHOLMOD: pass this binary on under the GPL only)" : "no",
      EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
}

std::string version_number() { return MAGIMU_VERSION; }

}  // namespace magimu::apps
