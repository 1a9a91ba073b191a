// SPDX-License-Identifier: BSD-3-Clause
// Table I of Huang et al. 2025, drawn: parameters.h.
#include "sim/draws/parameters.h"

#include <cmath>

#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kFieldStrength = 27.0;  // uT

Matrix3 skewness(double zeta, double eta, double rho) {
  Matrix3 m;
  m << 1.0, 0.0, 0.0,                     //
      std::sin(zeta), std::cos(zeta), 0,  //
      -std::sin(eta), std::cos(eta) * std::sin(rho), std::cos(eta) * std::cos(rho);
  return m;
}

Matrix3 draw_distortion(RandomStream& random) {
  const Vector3 scale = random.uniform3(0.9, 1.1);
  const Vector3 skew = random.uniform3(-10.0, 10.0) * kDegree;
  const Vector3 euler = random.uniform3(-5.0, 5.0) * kDegree;
  const Rot3 R_D = Rot3::Exp(Vector3(0, 0, euler[2])) * Rot3::Exp(Vector3(0, euler[1], 0)) *
                   Rot3::Exp(Vector3(euler[0], 0, 0));
  return kFieldStrength * scale.asDiagonal() * skewness(skew[0], skew[1], skew[2]) * R_D.matrix();
}

MagnetometerParameters draw_magnetometer(std::uint64_t seed, std::size_t index) {
  RandomStream random(seed, RandomPurpose::kMagnetometerParameters, index);
  MagnetometerParameters mag;
  mag.distortion = draw_distortion(random);
  mag.bias = random.uniform3(-2.0, 2.0);
  return mag;
}

}  // namespace

SensorParameters draw_parameters(std::uint64_t seed, int magnetometers) {
  RandomStream random(seed, RandomPurpose::kImuParameters);
  SensorParameters parameters;
  parameters.acc_bias = random.uniform3(-0.5, 0.5);
  parameters.gyr_bias = random.uniform3(0.47, 0.67) * kDegree;
  parameters.dip_rad = random.uniform(67.0, 77.0) * kDegree;
  parameters.mag.clear();
  for (int i = 0; i < magnetometers; ++i) {
    parameters.mag.push_back(draw_magnetometer(seed, static_cast<std::size_t>(i)));
  }
  return parameters;
}

double field_strength_uT(const Matrix3& distortion) {
  return std::cbrt(distortion.row(0).cross(distortion.row(1)).dot(distortion.row(2)));
}

std::vector<std::string> magnetometer_names(std::size_t count) {
  if (count == 1) return {"mag"};
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= count; ++i) names.push_back("mag" + std::to_string(i));
  return names;
}

}  // namespace magimu
