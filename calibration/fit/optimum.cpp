// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/optimum.h"

namespace magimu {

Optimum::Optimum(const Stage& fitted)
    : stage(fitted), system(fitted.graph(), fitted.result().values), rows(fitted.graph(), system) {
  system.linearize(fitted.result().values);
}

}  // namespace magimu
