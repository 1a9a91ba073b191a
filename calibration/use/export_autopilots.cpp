// SPDX-License-Identifier: BSD-3-Clause
// Parameter files of PX4 and ArduPilot. Their conventions, as in their sources:
//
//   PX4        src/lib/sensor_calibration/Magnetometer.hpp, Correct():
//              rotation * (scale * (data - offset)), gauss, scale symmetric with the diagonal
//              {X,Y,Z}SCALE and (0,1), (0,2), (1,2) = {X,Y,Z}ODIAG; Accelerometer.hpp:
//              rotation * ((data - offset) .* scale), m/s^2; Gyroscope.hpp: data - offset, rad/s.
//              CAL_MAGn_ROLL/PITCH/YAW make CAL_MAGn_ROT "custom Euler angle" (user guide, "Flight
//              Controller/Sensor Orientation").
//   ArduPilot  libraries/AP_Compass/AP_Compass_Backend.cpp: rotate_field() first, then
//              correct_field(): mat * (mag + offsets) * scale, milligauss, mat symmetric with DIA
//              on the diagonal and (0,1), (0,2), (1,2) = ODI; AP_InertialSensor_Backend.cpp:
//              offsets are subtracted. COMPASS_ORIENT 101 is custom rotation 1,
//              CUST_ROT1_ROLL/PITCH/YAW.
//
// PX4's file is QGroundControl's: vehicle, component, name, value, type, with tabs between.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <tuple>

#include "calibration/use/apply.h"
#include "calibration/use/export_text.h"
#include "recording/data/axes.h"

namespace magimu {
namespace {

constexpr double kGauss = 100.0, kMilligauss = 0.1;  // uT
constexpr std::size_t kPx4Mags = 4, kArdupilotMags = 3;
constexpr double kSmallAngle = 0.05;   // degrees; below, the rotation is not worth a word
constexpr double kHarmfulAngle = 5.0;  // degrees by which a heading may be off
const char* const kFrames =
    "Axes: the recording's are taken to be those in which the autopilot's drivers report the "
    "sensors, before its own calibration.";

class Parameters {
 public:
  explicit Parameters(bool px4) : px4_(px4) {}
  void real(const std::string& name, double value) {
    text += px4_ ? fmt::format("1\t1\t{}\t{:.12g}\t9\n", name, value)
                 : fmt::format("{},{:.12g}\n", name, value);
  }
  void integer(const std::string& name, int value) {
    text +=
        px4_ ? fmt::format("1\t1\t{}\t{}\t6\n", name, value) : fmt::format("{},{}\n", name, value);
  }
  // before + "X" + after and so on.
  void vector(const std::string& before, const std::string& after, const Vector3& v) {
    for (int i = 0; i < 3; ++i) real(fmt::format("{}{}{}", before, "XYZ"[i], after), v[i]);
  }
  void comment(const std::string& line) { text += "# " + line + "\n"; }

  std::string text;

 private:
  bool px4_;
};

Vector3 off_diagonal(const Matrix3& S) { return {S(0, 1), S(0, 2), S(1, 2)}; }

double angle_deg(const Matrix3& Q) { return Eigen::AngleAxisd(Q).angle() / kDegree; }

// corrected = matrix (raw - offset), with all that corrects a sensor: what the autopilot had
// applied to the log, and what was found in it.
struct WholeCorrection {
  int number = 0;  // of the parameters
  Matrix3 matrix = Matrix3::Identity();
  Vector3 offset = Vector3::Zero();
  Matrix3 mounted = Matrix3::Identity();  // the rotation that the autopilot has a parameter for
};

WholeCorrection whole_correction(const std::string& sensor, int number, const Matrix3& M,
                                 const Vector3& bias, Autopilot target,
                                 const ExportOptions& options) {
  const auto before = options.applied.find(sensor);
  if (before == options.applied.end() || before->second.by != target) {
    return {number, M, bias, Matrix3::Identity()};
  }
  const AppliedCorrection& is = before->second;
  return {is.number, M * is.matrix, is.offset + is.matrix.inverse() * bias, is.rotation};
}

WholeCorrection whole_mag(const Calibration& c, std::size_t m, Autopilot target,
                          const ExportOptions& options) {
  return whole_correction(c.mag_names[m], int(m), export_matrix(c, m, options),
                          c.parameters.mag[m].bias, target, options);
}

// What the symmetric matrix cannot hold, in the vehicle's axes.
Matrix3 rotation_left(const WholeCorrection& whole) {
  return polar_parts(whole.matrix).rotation * whole.mounted.transpose();
}

void tell_applied(const ExportOptions& options, Autopilot target, std::vector<std::string>& head) {
  std::vector<std::string> sensors;
  for (const auto& [sensor, is] : options.applied) {
    if (is.by == target) sensors.push_back(sensor);
  }
  if (sensors.empty()) return;
  head.push_back(
      fmt::format("The log's {} had been corrected by the vehicle's parameters; these are the new "
                  "ones, with those and what was found in the log together.",
                  fmt::join(sensors, ", ")));
}

std::string lost_rotation(const std::string& name, const Matrix3& Q) {
  const Vector3 rpy = roll_pitch_yaw_deg(Q);
  return fmt::format(
      "the rotation of {} against the IMU, {:.2f} deg (roll {:.12g}, pitch {:.12g}, yaw {:.12g}): "
      "the matrix is symmetric and cannot hold it. --with-rotation carries it as mounting angles.",
      name, angle_deg(Q), rpy[0], rpy[1], rpy[2]);
}

// A lost rotation turns headings by about its angle. That does harm where it is more than the
// calibration's own uncertainty; a few degrees a vehicle bears.
double harmful_angle_deg(const Calibration& c, std::size_t m) {
  const bool known = m < c.magnetometers.size();
  return std::max(kHarmfulAngle, known ? c.magnetometers[m].direction_sigma_deg : 0.0);
}

// Of the 24 rotations that carry axes to axes.
Matrix3 nearest_axes(const Matrix3& Q) {
  std::vector<Matrix3> all = signed_permutations();
  std::erase_if(all, [](const Matrix3& axes) { return axes.determinant() < 0.0; });
  return *std::ranges::max_element(all, {},
                                   [&](const Matrix3& axes) { return axes.cwiseProduct(Q).sum(); });
}

// The axes to turn to, and what is left then.
std::string remedy_by_axes(const std::string& name, const Matrix3& Q) {
  const Matrix3 axes = nearest_axes(Q);
  if (axes.isIdentity()) return "";
  return fmt::format(
      " Or turn the axes: calibrate with --axes {}={}, set the same turn as the orientation of "
      "this "
      "magnetometer in the autopilot, and {:.2g} deg are left.",
      name, axes_text(axes), angle_deg(Q * axes.transpose()));
}

std::string harm_of(const std::string& name, const Matrix3& Q) {
  return fmt::format(
      "{} is turned by {:.1f} deg against the IMU, and the file cannot hold that: headings would "
      "be "
      "wrong by as much. Carry it as mounting angles, for external magnetometers: "
      "--with-rotation.{}",
      name, angle_deg(Q), remedy_by_axes(name, Q));
}

// Losses that make headings wrong. count: magnetometers the target has.
std::vector<std::string> harms(const Calibration& c, Autopilot target, const ExportOptions& options,
                               std::size_t count) {
  std::vector<std::string> out;
  if (options.with_rotation || !options.writes("mag")) return out;
  for (std::size_t m = 0; m < std::min(count, c.mag_names.size()); ++m) {
    const Matrix3 Q = rotation_left(whole_mag(c, m, target, options));
    if (angle_deg(Q) > harmful_angle_deg(c, m)) out.push_back(harm_of(c.mag_names[m], Q));
  }
  return out;
}

// What both lose. count: magnetometers the target has.
std::vector<std::string> losses(const Calibration& c, Autopilot target,
                                const ExportOptions& options, std::size_t count) {
  std::vector<std::string> lost;
  for (std::size_t m = 0; m < std::min(count, c.mag_names.size()); ++m) {
    const Matrix3 Q = rotation_left(whole_mag(c, m, target, options));
    if (!options.with_rotation && angle_deg(Q) > kSmallAngle) {
      lost.push_back(lost_rotation(c.mag_names[m], Q));
    }
  }
  if (c.mag_names.size() > count) {
    lost.push_back(fmt::format("the magnetometers after the first {}.", count));
  }
  const std::vector<std::string> effects = lost_effects(c, {});
  lost.insert(lost.end(), effects.begin(), effects.end());
  return lost;
}

}  // namespace

Exported export_px4(const Calibration& c, const ExportOptions& options) {
  constexpr Autopilot kTarget = Autopilot::kPx4;
  Exported out{"", losses(c, kTarget, options, kPx4Mags), harms(c, kTarget, options, kPx4Mags)};
  std::vector<std::string> head{
      "Parameters of PX4 for QGroundControl (Parameters, Tools, Load from file).",
      "mag = S (raw - off), gauss; acc = raw - off, m/s^2; gyro = raw - off, rad/s.",
      raw_units("gauss", kGauss), kFrames,
      // NOLINTNEXTLINE(bugprone-suspicious-missing-comma): a sentence of two lines
      "CAL_MAGn_ID, CAL_ACC0_ID and CAL_GYRO0_ID must already name these sensors: calibrate once "
      "on "
      "the vehicle.",
      "PX4 may change the offsets later: SENS_MAG_AUTOCAL, SENS_IMU_AUTOCAL."};
  tell_applied(options, kTarget, head);
  if (options.with_rotation) {
    head.push_back(
        "CAL_MAGn_ROLL/PITCH/YAW: PX4 1.14 and later, external magnetometers only; for "
        "an IMU mounted along the vehicle.");
  }
  for (std::size_t m = 0; m < c.mag_names.size() && mag_lag_s(c, m) != 0.0; ++m) {
    const double lag_ms = 1e3 * mag_lag_s(c, m);
    head.push_back(fmt::format(
        "EKF2_MAG_DELAY is the place for a lag; {}",
        lag_ms > 0.0 ? fmt::format("this one is {:.1f} ms.", lag_ms)
                     : fmt::format("this magnetometer is {:.1f} ms ahead, for which it has none.",
                                   -lag_ms)));
  }
  Parameters p(true);
  const std::size_t mags = options.writes("mag") ? std::min(kPx4Mags, c.mag_names.size()) : 0;
  for (std::size_t m = 0; m < mags; ++m) {
    const WholeCorrection whole = whole_mag(c, m, kTarget, options);
    const std::string name = fmt::format("CAL_MAG{}_", whole.number);
    const PolarParts parts = polar_parts(whole.matrix);
    p.vector(name, "OFF", whole.offset / kGauss);
    p.vector(name, "SCALE", parts.symmetric.diagonal());
    p.vector(name, "ODIAG", off_diagonal(parts.symmetric));
    if (!options.with_rotation) continue;
    const Vector3 rpy = roll_pitch_yaw_deg(parts.rotation);
    p.real(name + "ROLL", rpy[0]);
    p.real(name + "PITCH", rpy[1]);
    p.real(name + "YAW", rpy[2]);
  }
  // Scales of the accelerometer are not estimated: those on the vehicle stay as they are.
  for (const auto& [sensor, name, bias] : {std::tuple("acc", "ACC", &c.parameters.acc_bias),
                                           {"gyr", "GYRO", &c.parameters.gyr_bias}}) {
    if (!options.writes(sensor)) continue;
    const WholeCorrection whole =
        whole_correction(sensor, 0, Matrix3::Identity(), *bias, kTarget, options);
    p.vector(fmt::format("CAL_{}{}_", name, whole.number), "OFF", whole.offset);
  }
  out.text = comment_head(c, options, head, out.lost, "#") + p.text;
  return out;
}

Exported export_ardupilot(const Calibration& c, const ExportOptions& options) {
  // One pair of custom rotations serves two magnetometers.
  const std::size_t count = options.with_rotation ? 2 : kArdupilotMags;
  constexpr Autopilot kTarget = Autopilot::kArdupilot;
  Exported out{"", losses(c, kTarget, options, count), harms(c, kTarget, options, count)};
  std::vector<std::string> head{
      // NOLINTNEXTLINE(bugprone-suspicious-missing-comma): a sentence of two lines
      "Parameters of ArduPilot (Mission Planner: Full Parameter List, Load from file; MAVProxy: "
      "param load).",
      "mag = S (raw + ofs), milligauss; acc = raw - offs, m/s^2; gyro = raw - offs, rad/s.",
      raw_units("milligauss", kMilligauss),
      kFrames,
      "The gyroscope is calibrated anew at every start unless INS_GYR_CAL is 0.",
      "COMPASS_DEV_ID and INS_ACC_ID must already name these sensors: calibrate once on the "
      "vehicle."};
  tell_applied(options, kTarget, head);
  if (options.with_rotation) {
    head.push_back(
        "CUST_ROT: ArduPilot 4.2 and later, external magnetometers only; offsets and "
        "matrix hold in the axes after it.");
  }
  Parameters p(false);
  const std::size_t mags = options.writes("mag") ? std::min(count, c.mag_names.size()) : 0;
  for (std::size_t m = 0; m < mags; ++m) {
    const std::string number = m == 0 ? "" : fmt::format("{}", m + 1);
    const PolarParts parts = polar_parts(export_matrix(c, m, options));
    // The mounting rotation comes first here: offsets and matrix hold in the turned axes.
    const Matrix3 Q = options.with_rotation ? parts.rotation : Matrix3(Matrix3::Identity());
    const Matrix3 S = Q * parts.symmetric * Q.transpose();
    p.vector("COMPASS_OFS" + number + "_", "", -Q * c.parameters.mag[m].bias / kMilligauss);
    p.real("COMPASS_SCALE" + number, 1.0);
    p.vector("COMPASS_DIA" + number + "_", "", S.diagonal());
    p.vector("COMPASS_ODI" + number + "_", "", off_diagonal(S));
    if (!options.with_rotation) continue;
    const Vector3 rpy = roll_pitch_yaw_deg(Q);
    if (m == 0) p.integer("CUST_ROT_ENABLE", 1);
    p.integer("COMPASS_ORIENT" + number, 101 + int(m));
    p.real(fmt::format("CUST_ROT{}_ROLL", m + 1), rpy[0]);
    p.real(fmt::format("CUST_ROT{}_PITCH", m + 1), rpy[1]);
    p.real(fmt::format("CUST_ROT{}_YAW", m + 1), rpy[2]);
  }
  // Scales of the accelerometer are not estimated: those on the vehicle stay as they are.
  for (const auto& [sensor, name, bias] :
       {std::tuple("acc", "ACC", &c.parameters.acc_bias), {"gyr", "GYR", &c.parameters.gyr_bias}}) {
    if (!options.writes(sensor)) continue;
    const WholeCorrection whole =
        whole_correction(sensor, 0, Matrix3::Identity(), *bias, kTarget, options);
    const std::string number = whole.number == 0 ? "" : std::to_string(whole.number + 1);
    p.vector(fmt::format("INS_{}{}OFFS_", name, number), "", whole.offset);
  }
  out.text = comment_head(c, options, head, out.lost, "#") + p.text;
  return out;
}

}  // namespace magimu
