// SPDX-License-Identifier: BSD-3-Clause
// Stretches of time in which a magnetometer stands out from the rest of its recording.
#pragma once

#include <string>
#include <vector>

#include "calibration/result/calibration.h"

namespace magimu {

// Stretches in which the magnetometers' residual stands out. mag_squares: squared whitened
// residuals of every node, of all magnetometers together (Stage::mag_squares).
std::vector<Disturbance> find_disturbances(const Calibration& c,
                                           const std::vector<double>& mag_squares);

// The same of one magnetometer of an array, by its residual_series.
std::vector<Disturbance> find_disturbances(const Calibration& c, std::size_t magnetometer);

// " at 12-17 s and 31-34 s (up to 9.1 uT)"; empty where there are none.
std::string when_disturbed(const std::vector<Disturbance>& disturbances, bool with_recording);

// uT of one whitened residual; 0 where it is not known.
double unit_of_residuals(const ResidualSummary& of);

}  // namespace magimu
