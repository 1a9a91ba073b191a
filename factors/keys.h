// SPDX-License-Identifier: BSD-3-Clause
// The names of calibration's variables.
#pragma once

#include "graph/key.h"
#include "graph/sensor.h"

namespace magimu {

// Orientation of node k, IMU frame to n.
constexpr Key R(int k) { return {'R', std::uint32_t(k)}; }

// Velocity of node k in n, m/s, and its position relative to the middle of the turning point's
// reach, m.
constexpr Key V(int k) { return {'V', std::uint32_t(k)}; }
constexpr Key P(int k) { return {'P', std::uint32_t(k)}; }

namespace key {

inline constexpr Key acc_bias{'a', 0};    // o_a, Vector3, m/s^2
inline constexpr Key gyr_bias{'w', 0};    // o_w, Vector3, rad/s
inline constexpr Key gyr_matrix{'S', 0};  // scale errors, misalignment: GyroMatrix
inline constexpr Key dip{'i', 0};         // alpha, double, rad

// Magnetometer i of an array; the plain names are those of the first.
constexpr Key distortion_of(int i) { return {'D', std::uint32_t(i)}; }  // D, Matrix3, uT
constexpr Key mag_bias_of(int i) { return {'m', std::uint32_t(i)}; }    // o_m, Vector3, uT
// The same where the bias is not the same throughout: 0 is the one that holds now.
constexpr Key mag_bias_of(int i, int earlier) { return {'m', std::uint32_t(i + 1000 * earlier)}; }
// Seconds by which magnetometer i lags the gyroscope, double.
constexpr Key mag_time_offset_of(int i) { return {'l', std::uint32_t(i)}; }
// Where the sensor is in recording i, from the point that it is turned about (reach_factor.h): IMU
// frame, Vector3, m. Of a travelling sensor its steady velocity along its own axes, m/s.
constexpr Key lever_arm_of(int i) { return {'r', std::uint32_t(i)}; }
// The i-th parameter of all effects (calibration/model/extension.h), double.
constexpr Key effect(int i) { return {'e', std::uint32_t(i)}; }
inline constexpr Key distortion = distortion_of(0);
inline constexpr Key mag_bias = mag_bias_of(0);
constexpr Key bias_of(Sensor sensor) {
  return sensor == Sensor::kAcc ? acc_bias : sensor == Sensor::kGyr ? gyr_bias : mag_bias;
}

}  // namespace key
}  // namespace magimu
