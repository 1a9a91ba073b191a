// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/check_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/result/gyr_errors.h"
#include "calibration/trust/field_check.h"
#include "factors/effects/turn_words.h"
#include "recording/data/axes.h"

namespace magimu {
namespace {

bool concerns_imu(const AxesFinding& f) { return f.sensor == "acc" || f.sensor == "gyr"; }

bool agree(double dip_rad, int dip_sign) { return dip_rad * dip_sign > 0.0; }

std::string turned_magnetometer(const AxesFinding& f, double dip_rad, int dip_sign) {
  const std::string inverted = axes_text(-f.remedy);
  std::string text =
      fmt::format("The axes of {} are not the IMU's: x, y, z of the IMU are its {} or its {}. ",
                  f.sensor, axes_text(f.remedy), inverted);
  if (dip_sign == 0) {
    return text +
           fmt::format(
               "The distortion matrix holds the former, and that is right if a dip of {:+.0f} deg "
               "has the right sign (positive on the northern hemisphere; say which "
               "one yours is, --hemisphere, and this is settled); else turn its axes, --axes "
               "{}={}.",
               dip_rad / kDegree, f.sensor, inverted);
  }
  if (agree(dip_rad, dip_sign)) {
    return text +
           "The distortion matrix holds the former, as the sign of the dip at your place confirms.";
  }
  return text + fmt::format(
                    "The distortion matrix holds the former, but the dip of {:+.0f} deg has the "
                    "wrong sign for your place: it is the latter. Turn its axes, --axes "
                    "{}={}.",
                    dip_rad / kDegree, f.sensor, inverted);
}

// Of sensors whose axes agree; empty where the sign of the dip is as it should be.
std::string about_the_dip(double dip_rad, int dip_sign) {
  const char* here = dip_rad > 0.0 ? "northern" : "southern";
  if (dip_sign == 0) {
    return fmt::format(
        "The dip of {:+.0f} deg is that of the {} hemisphere; on the other one an odd number of "
        "the magnetometer's axes (or all of the accelerometer's) would be inverted, which no "
        "motion can tell (the hemisphere or the location can: --hemisphere, --location).",
        dip_rad / kDegree, here);
  }
  if (agree(dip_rad, dip_sign)) return "";
  return fmt::format(
      "But the dip of {:+.0f} deg is that of the {} hemisphere, which yours is not: an odd number "
      "of the magnetometer's axes (or all of the accelerometer's) are inverted. If it is all "
      "three of the magnetometer's, invert them, --axes mag=-x,-y,-z.",
      dip_rad / kDegree, here);
}

// Packages are misaligned by some 5 deg about each axis, and soft iron skewed by 10 deg turns the
// polar factor of D by up to 5 more (Huang et al. 2025, Table I): beyond is a mounting.
constexpr double kMounted_deg = 12.0;
// An IMU's own axes agree to a degree or two.
constexpr double kTurnedWithinImu_deg = 3.0;

// Turns of gyroscope and magnetometer against the accelerometer, whose axes are the IMU's. gyr:
// I + S. Where both are turned alike it is the accelerometer that is turned.
std::string mounted_text(const Matrix3& gyr, const Matrix3& distortion) {
  const auto g = turn_and_rest(gyr), m = turn_and_rest(distortion);
  const bool gyr_turned = g && g->angle() > kTurnedWithinImu_deg * kDegree && is_mostly_a_turn(*g);
  const bool mag_turned = m && m->angle() > kMounted_deg * kDegree;
  if (gyr_turned && mag_turned && (g->turn - m->turn).norm() < kMounted_deg * kDegree) {
    TurnAndRest acc = *g;
    acc.turn = -g->turn;
    return fmt::format("The accelerometer is {} against the gyroscope and the magnetometer.",
                       turned_words(acc));
  }
  std::string out;
  if (gyr_turned) {
    out = fmt::format("The gyroscope is {} against the accelerometer.", turned_words(*g));
  }
  if (mag_turned) {
    out += fmt::format("{}The magnetometer is {} against the IMU.", out.empty() ? "" : " ",
                       turned_words(*m));
  }
  return out;
}

}  // namespace

Check check_axes(const Mounting& mounting, const Matrix3& distortion, double dip_rad, int dip_sign,
                 const Matrix3& gyr) {
  if (std::abs(dip_rad) < kFlatDip_deg * kDegree) dip_sign = 0;  // it says nothing
  Check out{"axes", CheckStatus::kOk, 0.0, ""};
  for (const AxesFit& fit : mounting.fits) {
    out.value = std::max(out.value, fit.rms_straight_rad / kDegree);
  }
  if (mounting.status == MountingStatus::kUndecided) {
    out.status = CheckStatus::kCaution;
    out.sentence = mounting.sentence;
  } else if (mounting.status == MountingStatus::kConsistent) {
    const std::string more = about_the_dip(dip_rad, dip_sign);
    const std::string mounted = mounted_text(gyr, distortion);
    out.sentence =
        mounted.empty()
            ? fmt::format("The sensors' axes agree (to {:.1f} deg).", out.value)
            : mounted +
                  " The calibration's matrices hold that: corrected readings are in the axes of "
                  "the IMU, which are the accelerometer's.";
    if (!mounted.empty()) out.status = CheckStatus::kCaution;
    if (!more.empty()) out.sentence += " " + more;
    if (dip_sign != 0 && !more.empty()) out.status = CheckStatus::kBad;
  } else if (std::ranges::any_of(mounting.findings, concerns_imu)) {
    out.status = CheckStatus::kBad;
    out.sentence = mounting.sentence;
  } else {
    out.status = agree(dip_rad, dip_sign) ? CheckStatus::kCaution : CheckStatus::kBad;
    for (const AxesFinding& f : mounting.findings) {
      out.sentence += (out.sentence.empty() ? "" : " ") + turned_magnetometer(f, dip_rad, dip_sign);
    }
  }
  return out;
}

Mounting check_mounting(const std::vector<const Recording*>& recordings) {
  Mounting mounting;
  for (const Recording* r : recordings) {
    mounting = check_mounting(*r);
    if (mounting.status != MountingStatus::kUndecided) break;
  }
  return mounting;
}

void judge_axes(Calibration& c, const Mounting& mounting, const CalibrationOptions& options) {
  int dip_sign = options.dip_sign;
  if (const auto& start = options.initialization.dip_rad; dip_sign == 0 && start) {
    dip_sign = *start > 0.0 ? 1 : -1;
  }
  c.checks.push_back(check_axes(mounting, c.parameters.mag.front().distortion, c.parameters.dip_rad,
                                dip_sign, Matrix3::Identity() + gyr_errors(c)));
  if (c.checks.back().status != CheckStatus::kBad) return;
  const bool imu = std::ranges::any_of(mounting.findings, concerns_imu);
  c.trust.verdict = std::max(c.trust.verdict, imu ? Verdict::kNo : Verdict::kLimited);
  // First: where accelerometer and gyroscope disagree, everything else follows from it.
  const auto at = imu ? c.trust.reasons.begin() : c.trust.reasons.end();
  c.trust.reasons.insert(at, c.checks.back().sentence);
}

}  // namespace magimu
