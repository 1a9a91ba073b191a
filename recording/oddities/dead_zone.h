// SPDX-License-Identifier: BSD-3-Clause
// Whether a gyroscope that reads exactly 0 does so because its device writes 0 for small rates, and
// not because it had no sample: readings then come down to the same smallest size before they are
// 0.
#pragma once

#include "recording/data/recording.h"

namespace magimu {

bool zeroes_small_rates(const VectorSeries& gyr);

}  // namespace magimu
