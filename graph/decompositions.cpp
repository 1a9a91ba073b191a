// SPDX-License-Identifier: BSD-3-Clause
#include "graph/decompositions.h"

namespace Eigen {

MAGIMU_DECOMPOSITIONS(template);

}  // namespace Eigen
