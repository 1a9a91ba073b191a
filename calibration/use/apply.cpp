// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/use/apply.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/result/gyr_errors.h"
#include "calibration/use/apply_doubts.h"
#include "calibration/use/apply_effects.h"
#include "recording/data/error.h"
#include "recording/data/well_formed.h"

namespace magimu {
namespace {

std::string row(const Vector3& v) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v[0], v[1], v[2]);
}

// Under a text of so many characters: three rows, the first behind the text.
std::string matrix(const std::string& head, const Matrix3& m) {
  std::string out;
  for (int i = 0; i < 3; ++i) {
    out += (i == 0 ? head : "\n" + std::string(head.size(), ' ')) + row(m.row(i).transpose());
  }
  return out;
}

bool finite(const Calibration& c) {
  bool all = c.parameters.acc_bias.allFinite() && c.parameters.gyr_bias.allFinite() &&
             std::isfinite(c.strength_uT);
  for (const MagnetometerParameters& mag : c.parameters.mag) {
    all = all && mag.distortion.allFinite() && mag.bias.allFinite();
  }
  for (const ActiveEffect& effect : c.effects) {
    for (const ActiveEffect::Parameter& p : effect.parameters) all = all && std::isfinite(p.value);
  }
  return all;
}

void check(const Calibration& c, const Recording& r) {
  require_well_formed(r);
  require_complete(c);
  if (!finite(c)) {
    throw InputError(r.name, 0, 0, "the calibration has parameters that are not numbers",
                     "calibrate again");
  }
  if (r.mag.size() != c.parameters.mag.size()) {
    throw InputError(r.name, 0, 0,
                     fmt::format("it has {} magnetometers, the calibration {}", r.mag.size(),
                                 c.parameters.mag.size()),
                     "apply a calibration only to recordings of the device it was made with");
  }
}

void describe_basic(const Calibration& c, Applied& out) {
  out.formulas.push_back("acc_cal = acc - o_a, m/s^2\n  o_a = " + row(c.parameters.acc_bias));
  const Matrix3 S = gyr_scale_misalignment(c);
  if (S.isZero()) {
    out.formulas.push_back("gyr_cal = gyr - o_w, rad/s\n  o_w = " + row(c.parameters.gyr_bias));
  } else {
    out.formulas.push_back("gyr_cal = (I + S)^-1 (gyr - o_w), rad/s\n  o_w = " +
                           row(c.parameters.gyr_bias) + "\n" + matrix("  S   = ", S));
  }
  for (std::size_t m = 0; m < c.parameters.mag.size(); ++m) {
    const std::string name = c.mag_names[m];
    std::string text =
        fmt::format("{0}_cal = s D^-1 ({0} - o_m), uT, in the axes of the IMU\n", name) +
        matrix("  D   = ", c.parameters.mag[m].distortion) +
        "\n  o_m = " + row(c.parameters.mag[m].bias) +
        fmt::format("\n  s   = {:.6g}, so that\n", c.strength_uT);
    out.formulas.push_back(text + matrix("  s D^-1 = ", mag_correction(c, m)));
  }
}

// Times to the nanosecond: a difference of two clocks has no more digits than they have.
double moved(double t, double by) { return std::round((t - by) * 1e9) / 1e9; }

void move_times(const Calibration& c, const ApplyOptions& options, Applied& out) {
  for (std::size_t m = 0; m < c.parameters.mag.size(); ++m) {
    const double lag = mag_lag_s(c, m);
    if (lag == 0.0) continue;
    const std::string name = c.mag_names[m];
    if (!options.move_mag_times) {
      out.not_applied.push_back(
          fmt::format("{} {} by {:.6g} s: its samples keep their times, as asked for", name,
                      lag > 0.0 ? "lags" : "is ahead", std::abs(lag)));
      continue;
    }
    for (double& t : out.recording.mag[m].t) t = moved(t, lag);
    out.formulas.push_back(
        fmt::format("t of {0}_cal = t of {0} {1} {2:.6g} s (it {3}), in rows of their own", name,
                    lag > 0.0 ? "-" : "+", std::abs(lag), lag > 0.0 ? "lags" : "is ahead"));
  }
}

}  // namespace

void require_complete(const Calibration& c) {
  if (!c.parameters.mag.empty() && c.mag_names.size() == c.parameters.mag.size() &&
      c.strength_uT > 0.0) {
    return;
  }
  throw InputError("the calibration", 0, 0, "it is empty: nothing has been calibrated",
                   "take what calibrate() or read_calibration() returns");
}

Matrix3 mag_correction(const Calibration& c, std::size_t m) {
  return c.strength_uT * c.parameters.mag.at(m).distortion.inverse();
}

Vector3 corrected_mag(const Calibration& c, std::size_t m, const Vector3& mag_uT) {
  return mag_correction(c, m) * (mag_uT - c.parameters.mag.at(m).bias);
}

Matrix3 gyr_scale_misalignment(const Calibration& c) { return gyr_errors(c); }

Matrix3 acc_scale_misalignment(const Calibration& c) {
  Matrix3 L = Matrix3::Zero();
  for (const ActiveEffect& effect : c.effects) {
    if (effect.name != "acc_scale_misalignment") continue;
    const VectorXd theta = effect_theta(effect);
    for (int i = 0, e = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) L(i, j) += theta[e++];
    }
  }
  return L;
}

Matrix3 gyr_correction(const Calibration& c) {
  return (Matrix3::Identity() + gyr_scale_misalignment(c)).inverse();
}
Matrix3 acc_correction(const Calibration& c) {
  return (Matrix3::Identity() + acc_scale_misalignment(c)).inverse();
}

Vector3 corrected_gyr(const Calibration& c, const Vector3& gyr) {
  return gyr_correction(c) * (gyr - c.parameters.gyr_bias);
}

double mag_lag_s(const Calibration& c, std::size_t m) {
  for (const ActiveEffect& effect : c.effects) {
    if (effect.name != "mag_time_offset" || effect.parameters.empty()) continue;
    return effect.parameters[std::min(m, effect.parameters.size() - 1)].value;
  }
  return 0.0;
}

Applied apply(const Calibration& c, const Recording& recording, const ApplyOptions& options) {
  check(c, recording);
  Applied out{recording, {}, {}, {}};
  describe_basic(c, out);
  correct_readings(c, out);
  out.doubts = doubts_of_field(c, out.recording);
  move_times(c, options, out);
  out.recording.truth.reset();
  return out;
}

}  // namespace magimu
