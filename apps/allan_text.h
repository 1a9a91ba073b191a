// SPDX-License-Identifier: BSD-3-Clause
// The noise at rest in words, as a table, and as a page with Allan plots.
#pragma once

#include <string>
#include <vector>

#include "calibration/rest_noise/noise_at_rest.h"

namespace magimu::apps {

// A sentence for each of white noise, bias instability and random walk of a sensor.
std::vector<std::string> noise_sentences(const SensorNoise& sensor);
std::string allan_table(const RestNoise& noise);
std::string allan_report(const RestNoise& noise);

}  // namespace magimu::apps
