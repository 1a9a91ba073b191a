// SPDX-License-Identifier: BSD-3-Clause
// The numbers by which PX4 and ArduPilot name how a sensor is mounted (MAVLink's
// MAV_SENSOR_ORIENTATION). Internal to recording/logs.
#pragma once

#include <optional>

#include "graph/so3.h"

namespace magimu {

// From the sensor's axes to the vehicle's; empty for a number that says no fixed rotation.
std::optional<Matrix3> mount_rotation(double number);

// Rz(yaw) Ry(pitch) Rx(roll), of degrees.
Matrix3 rotation_by_angles(double roll_deg, double pitch_deg, double yaw_deg);

}  // namespace magimu
