// SPDX-License-Identifier: BSD-3-Clause
// What an autopilot had done to a sensor's readings before it logged them, by parameters of its own
// that the log holds as well:
//
//   logged = matrix (raw - offset),   matrix = rotation * S
//
// A calibration of such readings is what these parameters lack; with them an export
// (calibration/use/export.h) gives the new parameters. Recording::file_units carries the numbers,
// in entries of their own.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "graph/so3.h"

namespace magimu {

enum class Autopilot { kPx4, kArdupilot };

struct AppliedCorrection {
  Autopilot by = Autopilot::kPx4;
  int number = 0;                          // n of CAL_MAGn_; 0 of INS_ACCOFFS, 1 of INS_ACC2OFFS
  Matrix3 matrix = Matrix3::Identity();    // no unit
  Vector3 offset = Vector3::Zero();        // m/s^2, rad/s, uT, in the sensor's own axes
  Matrix3 rotation = Matrix3::Identity();  // from those to the vehicle's
};

// sensor: "acc", "gyr" or a magnetometer's name.
void set_applied(std::map<std::string, double>& file_units, const std::string& sensor,
                 const AppliedCorrection& applied);
std::optional<AppliedCorrection> applied_to(const std::map<std::string, double>& file_units,
                                            const std::string& sensor);
// After the readings were turned: new = axes * old.
void turn_applied(std::map<std::string, double>& file_units, const std::string& sensor,
                  const Matrix3& axes);

}  // namespace magimu
