// SPDX-License-Identifier: BSD-3-Clause
// The likelihood of a recording that selection and fit never saw.
#include "bench/power_study.h"

namespace magimu {

// Needs of the library: the negative log-likelihood of a recording under a calibration with its
// effects, the trajectory integrated out.
std::optional<double> second_recording_nll(const Recording&, const Calibration&) {
  return std::nullopt;
}

}  // namespace magimu
