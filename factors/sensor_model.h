// SPDX-License-Identifier: BSD-3-Clause
// The measurement models of the three sensors, each equation once, as templates that serve the
// factors, their derivatives and the simulation alike; and the parameters they share.
//
//   acc = -R' g + o_a          Huang et al. 2025, eq. (accelerometer model)
//   gyr = omega + o_w          eq. (dynamic model)
//   mag = D R' m(alpha) + o_m  eq. (magnetometer model)
//
// R turns IMU vectors into n (X east, Y magnetic north, Z up); g^n = (0, 0, -g0); the unit field is
// m(alpha) = (0, cos alpha, -sin alpha), alpha the dip, positive downward; D carries the strength.
#pragma once

#include <vector>

#include "graph/rot3.h"
#include "graph/sensor.h"

namespace magimu {

inline constexpr double kStandardGravity = 9.80665;  // m/s^2
inline constexpr double kDegree = 0.017453292519943295;

// The unit field in n.
template <class T>
Vec3<T> unit_field(const T& dip_rad) {
  using std::cos, std::sin;
  return Vec3<T>(T(0.0), cos(dip_rad), -sin(dip_rad));
}

// Gravity in n: points down.
inline Vector3 gravity_n(double g0) { return Vector3(0.0, 0.0, -g0); }

// What a sensor that only turns reads.
template <class T>
Vec3<T> accelerometer_model(const Rot3T<T>& nRb, const Vec3<T>& acc_bias, const Vector3& g_n) {
  return acc_bias - nRb.unrotate(Vec3<T>(g_n.template cast<T>()));
}

template <class T>
Vec3<T> magnetometer_model(const Rot3T<T>& nRb, const Mat3<T>& D, const Vec3<T>& mag_bias,
                           const T& dip_rad) {
  return D * nRb.unrotate(unit_field(dip_rad)) + mag_bias;
}

struct MagnetometerParameters {
  Matrix3 distortion = 50.0 * Matrix3::Identity();  // D, uT
  Vector3 bias = Vector3::Zero();                   // o_m, uT
};

// theta of the paper: what calibration is after.
struct SensorParameters {
  Vector3 acc_bias = Vector3::Zero();           // o_a, m/s^2
  Vector3 gyr_bias = Vector3::Zero();           // o_w, rad/s
  std::vector<MagnetometerParameters> mag{{}};  // one a magnetometer
  double dip_rad = 0.0;                         // alpha
};

// White noise: the sigma of one sample is density * sqrt(rate).
struct NoiseDensities {
  double acc = 0.0;  // m/s^2 per sqrt(Hz)
  double gyr = 0.0;  // rad/s per sqrt(Hz)
  double mag = 0.0;  // uT per sqrt(Hz)
};
constexpr double density_of(const NoiseDensities& noise, Sensor sensor) {
  return sensor == Sensor::kAcc ? noise.acc : sensor == Sensor::kGyr ? noise.gyr : noise.mag;
}

}  // namespace magimu
