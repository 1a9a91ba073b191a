// SPDX-License-Identifier: BSD-3-Clause
// The true constants of a device and its surroundings, and their noise. Models, as in
// docs/theory.md:
//   acc = -R^T g^n + o_a + e_a,   gyr = omega + o_w + e_w,   mag = D R^T m(alpha) + o_m + e_m.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace magimu::oracle {

struct Device {
  Eigen::Vector3d acc_bias = Eigen::Vector3d::Zero();               // o_a, m/s^2
  Eigen::Vector3d gyr_bias = Eigen::Vector3d::Zero();               // o_w, rad/s
  Eigen::Matrix3d distortion = 27.0 * Eigen::Matrix3d::Identity();  // D, uT
  Eigen::Vector3d mag_bias = Eigen::Vector3d::Zero();               // o_m, uT
  double dip_rad = 1.25;                                            // alpha, positive downward

  double strength_uT() const;          // cube root of det D
  Eigen::Vector3d unit_field() const;  // m(alpha), in n
};

enum class DeviceKind {
  // Huang et al. 2025, Table I, uniform: o_a +-0.5 m/s^2; o_w 0.47 to 0.67 deg/s; scale factors 0.9
  // to 1.1; skewness angles +-10 deg; Euler angles of the misalignment +-5 deg; o_m +-2 uT; dip 67
  // to 77 deg. 27 uT.
  kTableI,
  // A board with iron and batteries, uniform: o_a +-0.3 m/s^2; o_w +-1 deg/s; the same scale
  // factors, skewness and misalignment; o_m +-30 uT; dip 55 to 75 deg; 48 uT.
  kBoard,
};
Device draw_device(DeviceKind kind, std::uint64_t seed);

// White noise per sqrt(Hz): sigma of a sample = density * sqrt(rate).
struct Densities {
  double acc, gyr, mag;  // m/s^2, rad/s, uT
};
inline constexpr Densities kTableIDensities{0.02, 8.7e-4, 0.003};    // of the paper
inline constexpr Densities kRealisticDensities{2e-3, 1.5e-4, 0.05};  // of usual MEMS sensors

}  // namespace magimu::oracle
