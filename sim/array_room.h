// SPDX-License-Identifier: BSD-3-Clause
// An array of magnetometers carried around a square in a room of dipoles: iron in the walls, the
// floor and the ceiling, and the Earth's field. The field of dipoles is free of curl and divergence
// wherever none of them is, so it is what the field models of navigation/ are made for, but for
// their truncation.
//
// The IMU's readings are as Recording has them: the accelerometer's samples are instants, the
// gyroscope's are exact means over [t_k, t_k+1).
#pragma once

#include <cstdint>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

struct ArrayRoomOptions {
  std::uint64_t seed = 1;
  std::vector<Vector3> positions;  // of the magnetometers in the body frame, m
  double rate_hz = 100.0, duration_s = 8.0;
  double side_m = 1.8, lap_s = 4.0;  // of the square (with round corners), and its time a lap
  double gravity = 9.82;             // m/s^2
  double acc_noise = 0.05;           // m/s^2, standard deviation a sample
  double gyr_noise = 0.0087266;      // rad/s, 0.5 deg/s
  double mag_noise = 0.1;            // uT
  double acc_bias = 0.2, gyr_bias = 0.005;  // standard deviations of constant biases
  int dipoles = 40;     // in the walls, floor and ceiling of a room of 5 x 5 x 2.4 m
  double moment = 8.0;  // A m^2, standard deviation of a dipole's components
};

// With the truth. Throws InputError without positions or with a rate or duration out of range.
Recording simulate_array(const ArrayRoomOptions& options);

// The field of the room of that seed at a place, uT.
Vector3 room_field(const ArrayRoomOptions& options, const Vector3& place);

}  // namespace magimu
