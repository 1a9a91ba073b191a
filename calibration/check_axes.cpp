// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/check_axes.h"

#include <fmt/format.h>

#include <algorithm>

#include "recording/axes.h"

namespace magimu {
namespace {

// What no motion can tell; the user can.
std::string about_the_dip(double dip_rad) {
  return fmt::format(
      "The dip of {:+.0f} deg is that of the {} hemisphere; on the other one an odd number of the "
      "magnetometer's axes (or all of the accelerometer's) would be inverted, which no motion can "
      "tell.",
      dip_rad / kDegree, dip_rad > 0.0 ? "northern" : "southern");
}

bool concerns_imu(const AxesFinding& f) { return f.sensor == "acc" || f.sensor == "gyr"; }

std::string turned_magnetometer(const AxesFinding& f, double dip_rad, bool sign_known) {
  const std::string inverted = axes_text(-f.remedy);
  const std::string text = fmt::format(
      "The axes of {} are not the IMU's: x, y, z of the IMU are its {} or its {}. The distortion "
      "matrix holds the former, ",
      f.sensor, axes_text(f.remedy), inverted);
  if (sign_known) return text + "as the sign of the given dip confirms.";
  return text +
         fmt::format(
             "and that is right if a dip of {:+.0f} deg has the right sign (positive on the "
             "northern hemisphere; give --dip, and this is settled); else give --axes {}={}.",
             dip_rad / kDegree, f.sensor, inverted);
}

}  // namespace

Check check_axes(const Mounting& mounting, double dip_rad, std::optional<double> known_dip_rad) {
  Check out{"axes", CheckStatus::kOk, 0.0, ""};
  for (const AxesFit& fit : mounting.fits) {
    out.value = std::max(out.value, fit.rms_straight_rad / kDegree);
  }
  const bool sign_known = known_dip_rad && *known_dip_rad * dip_rad > 0.0;
  if (mounting.status == MountingStatus::kUndecided) {
    out.status = CheckStatus::kCaution;
    out.sentence = mounting.sentence;
  } else if (mounting.status == MountingStatus::kConsistent) {
    out.sentence = fmt::format("The sensors' axes agree (to {:.1f} deg).{}", out.value,
                               sign_known ? "" : " " + about_the_dip(dip_rad));
  } else if (std::ranges::any_of(mounting.findings, concerns_imu)) {
    out.status = CheckStatus::kBad;
    out.sentence = mounting.sentence;
  } else {
    out.status = sign_known ? CheckStatus::kCaution : CheckStatus::kBad;
    out.sentence = turned_magnetometer(mounting.findings.front(), dip_rad, sign_known);
  }
  return out;
}

void judge_axes(Calibration& c, const std::vector<const Recording*>& recordings,
                const CalibrationOptions& options) {
  Mounting mounting;
  for (const Recording* r : recordings) {
    mounting = check_mounting(*r);
    if (mounting.status != MountingStatus::kUndecided) break;
  }
  c.checks.push_back(check_axes(mounting, c.parameters.dip_rad, options.initialization.dip_rad));
  if (c.checks.back().status != CheckStatus::kBad) return;
  const bool imu = std::ranges::any_of(mounting.findings, concerns_imu);
  c.trust.verdict = std::max(c.trust.verdict, imu ? Verdict::kNo : Verdict::kLimited);
  // First: where accelerometer and gyroscope disagree, everything else follows from it.
  const auto at = imu ? c.trust.reasons.begin() : c.trust.reasons.end();
  c.trust.reasons.insert(at, c.checks.back().sentence);
}

}  // namespace magimu
