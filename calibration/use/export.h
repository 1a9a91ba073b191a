// SPDX-License-Identifier: BSD-3-Clause
// A calibration in another system's own names, units and convention:
//
//   px4        CAL_MAGn_*, CAL_ACC0_*, CAL_GYRO0_*     S (raw - off), gauss; S symmetric
//   ardupilot  COMPASS_OFS/DIA/ODI, INS_*              S (raw + ofs), milligauss; S symmetric
//   ros        parameters of a bias remover, YAML      scale (raw - bias), tesla
//   matlab     A, b, expmfs of magcal                  C = (D - b) A, rows, uT
//   c          a header with arrays and functions      C99, uT
//
// Ours is M (raw - o_m), M = s D^-1 (apply.h), which is not symmetric: besides gain and soft iron
// it turns the magnetometer's axes into those of the IMU. The autopilots' matrix cannot: M = Q S is
// taken apart (polar decomposition), S goes into the matrix and keeps every length, and the
// rotation Q is told, or carried by the sensor's mounting angles where that is asked for. A file
// that loses a large Q is harmful: headings would be off by its angle.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "calibration/result/calibration.h"
#include "recording/data/applied_correction.h"

namespace magimu {

enum class ExportTarget { kPx4, kArdupilot, kRos, kMatlab, kC };

struct ExportOptions {
  // The length of a corrected reading, uT, where a target scales by it. 0: the calibration's own
  // strength, the cube root of det D; give the field's true strength where it is known.
  double strength_uT = 0.0;
  // Autopilots: carry Q as mounting angles (PX4 1.14, ArduPilot 4.2 and later; of external
  // magnetometers only).
  bool with_rotation = false;
  // Autopilots: the parameters of these sensors only, "mag", "acc", "gyr". Default: of all.
  std::vector<std::string> only = {};
  std::string source = {};  // where the calibration comes from, for a comment
  // Sensors that were turned before the calibration, and how: {"mag", "y,-x,z"}. Raw readings have
  // to be turned alike, which the comment says.
  std::map<std::string, std::string> turned = {};
  // What the autopilot had applied to the readings of a sensor before they were logged. Its new
  // parameters are those and what was found together.
  std::map<std::string, AppliedCorrection> applied = {};

  bool writes(const std::string& sensor) const {
    return only.empty() || std::find(only.begin(), only.end(), sensor) != only.end();
  }
};

struct Exported {
  std::string text;               // the file
  std::vector<std::string> lost;  // what the target cannot hold, in sentences (also in the text)
  // A loss that makes headings wrong, with its remedy, in sentences; empty: none. Such a file
  // should not be used.
  std::vector<std::string> harmful;
};

// Look at Calibration::trust first: with the verdict `no` parameters may be placeholders.
// InputError where the calibration is empty.
Exported export_calibration(const Calibration& calibration, ExportTarget target,
                            const ExportOptions& options = {});

// M = Q S with S symmetric, positive definite, and Q a rotation (det M > 0): |S x| = |M x|.
struct PolarParts {
  Matrix3 rotation, symmetric;
};
PolarParts polar_parts(const Matrix3& M);

// Roll, pitch, yaw, degrees, of Q = Rz(yaw) Ry(pitch) Rx(roll).
Vector3 roll_pitch_yaw_deg(const Matrix3& rotation);

}  // namespace magimu
