// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/use/export.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "calibration/use/apply.h"
#include "calibration/use/export_text.h"
#include "graph/decompositions.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

constexpr std::size_t kWidth = 98;  // characters a comment line

}  // namespace

Exported export_calibration(const Calibration& c, ExportTarget target,
                            const ExportOptions& options) {
  require_complete(c);
  switch (target) {
    case ExportTarget::kPx4:
      return export_px4(c, options);
    case ExportTarget::kArdupilot:
      return export_ardupilot(c, options);
    case ExportTarget::kRos:
      return export_ros(c, options);
    case ExportTarget::kMatlab:
      return export_matlab(c, options);
    case ExportTarget::kC:
      return export_c(c, options);
  }
  return {};
}

PolarParts polar_parts(const Matrix3& M) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> squared(MatrixXd(M.transpose() * M));
  const Matrix3 S = squared.operatorSqrt();
  return {M * S.inverse(), S};
}

Vector3 roll_pitch_yaw_deg(const Matrix3& Q) {
  const double pitch = std::asin(std::clamp(-Q(2, 0), -1.0, 1.0));
  return Vector3(std::atan2(Q(2, 1), Q(2, 2)), pitch, std::atan2(Q(1, 0), Q(0, 0))) / kDegree;
}

double export_strength_uT(const Calibration& c, const ExportOptions& options) {
  return options.strength_uT > 0.0 ? options.strength_uT : c.strength_uT;
}

Matrix3 export_matrix(const Calibration& c, std::size_t m, const ExportOptions& options) {
  return export_strength_uT(c, options) / c.strength_uT * mag_correction(c, m);
}

std::string comment_head(const Calibration& c, const ExportOptions& options,
                         const std::vector<std::string>& lines,
                         const std::vector<std::string>& lost, const std::string& sign) {
  std::string out;
  const auto add = [&](const std::string& text) {
    std::string line = sign;
    std::istringstream words(text);
    for (std::string word; words >> word; line += " " + word) {
      if (line.size() + word.size() < kWidth || line == sign) continue;
      out += line + "\n";
      line = sign;
    }
    out += line + "\n";
  };
  const std::string from = options.source.empty() ? "" : " from " + quoted_text(options.source);
  add(fmt::format("Written by magimu export{}; its verdict: {}.", from,
                  to_string(c.trust.verdict)));
  for (const auto& [sensor, axes] : options.turned) {
    add(fmt::format("Turn raw readings first: {} = ({}) of the sensor's own axes.", sensor, axes));
  }
  for (const std::string& line : lines) add(line);
  for (const std::string& sentence : lost) add("LOST: " + sentence);
  return out;
}

std::string raw_units(const std::string& field_unit, double uT) {
  struct Unit {
    const char* name;
    double uT;
  };
  constexpr Unit kFieldUnits[] = {
      {"uT", 1.0}, {"nT", 1e-3}, {"milligauss", 0.1}, {"gauss", 100.0}, {"tesla", 1e6}};
  std::string factors;
  for (const Unit& unit : kFieldUnits) {
    if (unit.name != field_unit) factors += fmt::format(", {} by {:.6g}", unit.name, unit.uT / uT);
  }
  return fmt::format(
      "Raw readings must come in m/s^2, rad/s and {}, along the axes of the recording. Multiply g "
      "by 9.80665, deg/s by 0.0174532925{}; counts by the factors with which they were read for "
      "the calibration.",
      field_unit, factors);
}

std::vector<std::string> lost_effects(const Calibration& c, const Carries& carries) {
  std::vector<std::string> out;
  const Matrix3 S = gyr_scale_misalignment(c);
  for (const ActiveEffect& effect : c.effects) {
    if (effect.name == "mag_time_offset") {
      for (std::size_t m = 0; m < c.mag_names.size() && !carries.lag; ++m) {
        const double lag = mag_lag_s(c, m);
        out.push_back(fmt::format("{} {} the gyroscope by {:.4f} s in the recording.",
                                  c.mag_names[m], lag < 0.0 ? "is ahead of" : "lags",
                                  std::abs(lag)));
      }
    } else if (effect.name == "gyro_scale_misalignment") {
      if (carries.matrices) continue;
      out.push_back(
          fmt::format("the gyroscope's scale errors and misalignment (up to {:.2f} %), for which "
                      "there is no parameter.",
                      100.0 * S.cwiseAbs().maxCoeff()));
    } else if (effect.name == "acc_scale_misalignment") {
      if (carries.matrices) continue;
      out.push_back(fmt::format(
          "the accelerometer's scale errors and misalignment (up to {:.2f} %), beside which its "
          "bias was found.",
          100.0 * acc_scale_misalignment(c).cwiseAbs().maxCoeff()));
    } else {
      out.push_back("the effect " + effect.name + ".");
    }
  }
  return out;
}

}  // namespace magimu
