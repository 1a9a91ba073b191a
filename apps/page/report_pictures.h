// SPDX-License-Identifier: BSD-3-Clause
// The pictures of a calibration's report, as SVG.
#pragma once

#include <string>
#include <vector>

#include "calibration/result/calibration.h"
#include "recording/data/recording.h"

namespace magimu::apps {

// Readings of a magnetometer about their middle, raw and corrected, seen along three axes, with the
// circle on which corrected readings should lie.
std::vector<std::string> sphere_pictures(const Calibration& calibration,
                                         const std::vector<const Recording*>& recordings,
                                         std::size_t magnetometer);
// Length of the readings over time, raw and corrected.
std::string length_picture(const Calibration& calibration,
                           const std::vector<const Recording*>& recordings,
                           std::size_t magnetometer);
// Cost and step of every iteration.
std::string convergence_picture(const Calibration& calibration);
// Where up and magnetic north pointed in the axes of the sensor.
std::string coverage_picture(const Calibration& calibration, bool gravity);
// Share of the sphere of directions, in 48 equal patches, into which they pointed at least once.
double coverage(const Calibration& calibration, bool gravity);

}  // namespace magimu::apps
