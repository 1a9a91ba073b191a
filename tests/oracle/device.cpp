// SPDX-License-Identifier: BSD-3-Clause
// Devices drawn from ranges: device.h.
#include "tests/oracle/device.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "tests/oracle/motion.h"
#include "tests/oracle/random.h"

namespace magimu::oracle {
namespace {

// D = strength * scale * skewness * misalignment, as in the paper.
Eigen::Matrix3d draw_distortion(double strength_uT, Random& random) {
  const Eigen::Vector3d scale = random.uniform3(0.9, 1.1);
  const Eigen::Vector3d skew = random.uniform3(-10.0, 10.0) * kDegree;
  const Eigen::Vector3d euler = random.uniform3(-5.0, 5.0) * kDegree;
  Eigen::Matrix3d lower = Eigen::Matrix3d::Zero();
  lower(0, 0) = 1.0;
  lower(1, 0) = std::sin(skew[0]);
  lower(1, 1) = std::cos(skew[0]);
  lower(2, 0) = -std::sin(skew[1]);
  lower(2, 1) = std::cos(skew[1]) * std::sin(skew[2]);
  lower(2, 2) = std::cos(skew[1]) * std::cos(skew[2]);
  const Eigen::Matrix3d turned = (Eigen::AngleAxisd(euler[2], Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(euler[1], Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(euler[0], Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
  return strength_uT * scale.asDiagonal() * lower * turned;
}

}  // namespace

double Device::strength_uT() const { return std::cbrt(distortion.determinant()); }

Eigen::Vector3d Device::unit_field() const { return {0.0, std::cos(dip_rad), -std::sin(dip_rad)}; }

Device draw_device(DeviceKind kind, std::uint64_t seed) {
  Random random(seed, Stream::kDevice);
  const bool paper = kind == DeviceKind::kTableI;
  Device device;
  device.acc_bias = paper ? random.uniform3(-0.5, 0.5) : random.uniform3(-0.3, 0.3);
  device.gyr_bias = kDegree * (paper ? random.uniform3(0.47, 0.67) : random.uniform3(-1.0, 1.0));
  device.distortion = draw_distortion(paper ? 27.0 : 48.0, random);
  device.mag_bias = paper ? random.uniform3(-2.0, 2.0) : random.uniform3(-30.0, 30.0);
  device.dip_rad = kDegree * (paper ? random.uniform(67.0, 77.0) : random.uniform(55.0, 75.0));
  return device;
}

}  // namespace magimu::oracle
