// SPDX-License-Identifier: BSD-3-Clause
// Axes that are not where they should be, and motions that show too little: fault_kinds.h.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bench/faults/fault_kinds.h"

namespace magimu {
namespace {

void turn(Damage& d, int s, const Matrix3& Q) {
  for (LogRow& row : d.log.rows) row.v[std::size_t(s)] = Q * row.v[std::size_t(s)];
}

// Of all magnetometers, and the truth with them: m' = Q D R' m(alpha) + Q o_m. Where Q inverts, the
// same readings come from -Q D, the opposite dip and an attitude turned by 180 deg about Z.
void turn_mags(Damage& d, const Matrix3& Q) {
  d.sensor = 2;
  const double sign = Q.determinant() < 0.0 ? -1.0 : 1.0;
  for (int s = 2; s < d.log.sensors(); ++s) {
    turn(d, s, Q);
    if (!d.truth) continue;
    MagnetometerParameters& mag = d.truth->mag[std::size_t(s - 2)];
    mag.distortion = sign * Q * mag.distortion;
    mag.bias = Q * mag.bias;
  }
  if (d.truth) d.truth->dip_rad *= sign;
}

Matrix3 inversion(Damage& d) {
  const int axis = int(d.dice.index(3));
  Matrix3 Q = Matrix3::Identity();
  Q(axis, axis) = -1.0;
  d.what += fmt::format("axis {}", "xyz"[axis]);
  return Q;
}

Matrix3 exchange(Damage& d) {
  const int a = int(d.dice.index(3)), b = (a + 1 + int(d.dice.index(2))) % 3;
  Matrix3 Q = Matrix3::Identity();
  Q.row(a).swap(Q.row(b));
  d.what += fmt::format("{} with {}", "xyz"[a], "xyz"[b]);
  return Q;
}

Matrix3 rotation(Damage& d, double least_deg, double most_deg) {
  Vector3 axis;
  for (double& x : axis) x = d.dice.normal();
  const double angle = d.dice.uniform(least_deg, most_deg);
  d.what += fmt::format("by {:.2f} deg", angle);
  return Eigen::AngleAxisd(angle * kDegree, axis.normalized()).toRotationMatrix();
}

Matrix3 quarter_turn(Damage& d) {
  const Vector3 axis = d.dice.sign() * Vector3::Unit(int(d.dice.index(3)));
  const int quarters = 1 + int(d.dice.index(2));
  d.what += fmt::format("by {} deg", 90 * quarters);
  return Eigen::AngleAxisd(90.0 * kDegree * quarters, axis).toRotationMatrix();
}

// Of the accelerometer or the gyroscope. The IMU frame is the accelerometer's (CONTRACT: gyr =
// (I + S) omega + o_w): one that is turned takes the frame of D with it, a turned gyroscope is in
// S, and each bias stays with its own sensor's axes.
template <Matrix3 (*kMatrix)(Damage&)>
void of_imu(Damage& d) {
  const int s = d.choose_imu();
  const Matrix3 Q = kMatrix(d);
  turn(d, s, Q);
  if (!d.truth) return;
  Vector3& bias = s == 0 ? d.truth->acc_bias : d.truth->gyr_bias;
  bias = Q * bias;
  if (s != 0 || Q.determinant() < 0.0) return;
  for (MagnetometerParameters& mag : d.truth->mag) mag.distortion = mag.distortion * Q.transpose();
}
template <Matrix3 (*kMatrix)(Damage&)>
void of_mag(Damage& d) {
  turn_mags(d, kMatrix(d));
}

Matrix3 mounting(Damage& d) { return rotation(d, 20.0, 60.0); }
Matrix3 small_mounting(Damage& d) { return rotation(d, 0.5, 10.0); }
Matrix3 all_three(Damage&) { return -Matrix3::Identity(); }

// Gravity downwards: as iOS has it. The same readings come from the opposite dip.
void acc_downward(Damage& d) {
  d.sensor = 0;
  turn(d, 0, -Matrix3::Identity());
  if (!d.truth) return;
  d.truth->acc_bias *= -1.0;
  d.truth->dip_rad *= -1.0;
}
void gyr_backward(Damage& d) {
  d.sensor = 1;
  turn(d, 1, -Matrix3::Identity());
}

// One device of an array, or all sensors together: harmless for all but the attitude's meaning.
void all_turned(Damage& d) {
  const Matrix3 Q = quarter_turn(d);
  for (int s = 0; s < d.log.sensors(); ++s) turn(d, s, Q);
  if (d.truth) {
    d.truth->acc_bias = Q * d.truth->acc_bias;
    d.truth->gyr_bias = Q * d.truth->gyr_bias;
    for (MagnetometerParameters& mag : d.truth->mag) {
      mag.distortion = Q * mag.distortion * Q.transpose();
      mag.bias = Q * mag.bias;
    }
  }
  d.sensor = -1;
}

// An axis of the magnetometer written into two columns.
void axis_twice(Damage& d) {
  const int s = d.choose_sensor(), from = int(d.dice.index(3)), to = (from + 1) % 3;
  for (LogRow& row : d.log.rows) row.v[std::size_t(s)][to] = row.v[std::size_t(s)][from];
  d.what += fmt::format("{} as {}, too", "xyz"[from], "xyz"[to]);
}

// The gyroscope's columns hold the accelerometer's numbers, or the other way round.
void sensors_exchanged(Damage& d) {
  const int a = int(d.dice.index(3)), b = (a + 1) % 3;
  for (LogRow& row : d.log.rows) std::swap(row.v[std::size_t(a)], row.v[std::size_t(b)]);
  d.what = d.log.names[std::size_t(a)] + " and " + d.log.names[std::size_t(b)];
}

template <oracle::MotionKind kMotion>
void moved_otherwise(Damage& d) {
  d.log = with_motion(d.base, kMotion);
  d.truth->mag.resize(1);
}

}  // namespace

void add_axis_faults(std::vector<FaultKind>& kinds) {
  const std::vector<std::string> axes = {"axes",    "axis",     "turned", "mounted", "invert",
                                         "swapped", "sign",     "handed", "--axes",  "misalign",
                                         "rotat",   "disagree", "frame"};
  const std::vector<std::string> motion = {"turned (hardly|about one|too little|only)",
                                           "axis",
                                           "axes",
                                           "motion",
                                           "rest",
                                           "does not (turn|move)",
                                           "rotat",
                                           "undetermined",
                                           "determin",
                                           "missing"};
  const auto add = [&](const char* name, bool of_sensor, bool seen, void (*apply)(Damage&)) {
    kinds.push_back({.name = name,
                     .words = axes,
                     .of_sensor = of_sensor,
                     .info_can_see = seen,
                     .apply = apply});
  };
  add("imu_axis_inverted", true, true, of_imu<inversion>);
  add("mag_axis_inverted", true, false, of_mag<inversion>);
  add("imu_axes_exchanged", true, true, of_imu<exchange>);
  add("mag_axes_exchanged", true, false, of_mag<exchange>);
  add("imu_turned", true, true, of_imu<quarter_turn>);
  add("mag_turned", true, false, of_mag<quarter_turn>);
  add("mag_mounted", true, false, of_mag<mounting>);
  add("imu_misaligned", true, false, of_imu<small_mounting>);
  add("mag_inverted", true, false, of_mag<all_three>);
  kinds.back().unnamed = true;  // the same readings come from the opposite dip
  add("acc_downward", true, false, acc_downward);
  kinds.back().unnamed = true;  // likewise
  add("gyr_backward", true, true, gyr_backward);
  add("all_turned", false, false, all_turned);
  kinds.back().unnamed = true;  // another name for the axes
  add("axis_twice", true, true, axis_twice);
  kinds.back().words.insert(kinds.back().words.end(), {"same", "equal", "copy", "identical"});
  add("sensors_exchanged", false, true, sensors_exchanged);
  kinds.back().words.insert(kinds.back().words.end(), {"unit", "gravity"});
  const auto add_motion = [&](const char* name, void (*apply)(Damage&)) {
    kinds.push_back({.name = name,
                     .words = motion,
                     .info_can_see = true,
                     .needs_simulation = true,
                     .apply = apply});
  };
  using enum oracle::MotionKind;
  add_motion("one_axis", moved_otherwise<kOneAxis>);
  add_motion("no_motion", moved_otherwise<kStill>);
  add_motion("short_turn", moved_otherwise<kShortTurn>);
  add_motion("translation", moved_otherwise<kTranslation>);
}

}  // namespace magimu
