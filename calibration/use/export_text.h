// SPDX-License-Identifier: BSD-3-Clause
// What the exports (export.h) share. For the export_*.cpp files.
#pragma once

#include "calibration/use/export.h"

namespace magimu {

// strength D^-1 of one magnetometer, with the strength that was asked for.
Matrix3 export_matrix(const Calibration& calibration, std::size_t magnetometer,
                      const ExportOptions& options);
double export_strength_uT(const Calibration& calibration, const ExportOptions& options);

// Lines that begin with a comment sign: what this is, verdict, what is lost.
std::string comment_head(const Calibration& calibration, const ExportOptions& options,
                         const std::vector<std::string>& lines,
                         const std::vector<std::string>& lost, const std::string& sign);

// In which units raw readings must come, of which one of the field is so many uT, and the factors
// from others.
std::string raw_units(const std::string& field_unit, double uT);

// What a target has a place for.
struct Carries {
  bool matrices = false;  // scale errors and misalignment of gyroscope and accelerometer
  bool lag = false;       // of the magnetometer
};
// "mag lags the gyroscope by ..." and so on: effects for which the target has none.
std::vector<std::string> lost_effects(const Calibration& calibration, const Carries& carries);

Exported export_px4(const Calibration& calibration, const ExportOptions& options);
Exported export_ardupilot(const Calibration& calibration, const ExportOptions& options);
Exported export_ros(const Calibration& calibration, const ExportOptions& options);
Exported export_matlab(const Calibration& calibration, const ExportOptions& options);
Exported export_c(const Calibration& calibration, const ExportOptions& options);

}  // namespace magimu
