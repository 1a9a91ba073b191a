// SPDX-License-Identifier: BSD-3-Clause
// Accelerations that phones write in two parts, the motion's and gravity's, and those of Apple's
// Core Motion, whose sign is the opposite of an accelerometer's: -1 g along z with the screen up.
// Internal to csv_columns.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace magimu {

struct AccelerationInParts {
  std::array<std::size_t, 3> gravity{}, motion{};  // columns of x, y, z
  bool apple = false;                              // their sum has the opposite sign
};

// "gravity.x" beside "userAcceleration.x" (Core Motion) or "linear_acceleration_x" (Android), with
// all axes.
std::optional<AccelerationInParts> acceleration_in_parts(const std::vector<std::string>& headers);

// SensorLog's "accelerometerAccelerationX(G)": Core Motion's, with its sign.
bool is_apples_accelerometer(const std::string& header);

}  // namespace magimu
