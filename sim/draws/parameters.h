// SPDX-License-Identifier: BSD-3-Clause
// The sensors of the paper's simulation study: Huang et al. 2025, Table I. All draws are uniform as
// the table has it (the text above it says Gaussian).
//
//   D = 27 uT D_diag D_skew R_D
//
// with the scale factors D_diag = diag(D11, D22, D33), the skewness D_skew of the angles zeta, eta,
// rho, and the rotation R_D of the Euler angles phi, gamma, psi about x, y, z:
// R_D = Rz(psi) Ry(gamma) Rx(phi) (the paper leaves the order open). The field's strength, 27 uT,
// is the paper's code's.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "factors/sensor_model.h"

namespace magimu {

// Table I's noise densities: m/s^2, rad/s (0.05 deg/s) and uT, each per sqrt(Hz).
inline constexpr NoiseDensities kPaperNoise{0.02, 0.05 * kDegree, 0.003};

// m/s^2, of the paper's code.
inline constexpr double kPaperGravity = 9.8;

// The IMU and each magnetometer draw from streams of their own: with one more magnetometer the
// others stay as they were.
SensorParameters draw_parameters(std::uint64_t seed, int magnetometers);

// The cube root of det D, uT.
double field_strength_uT(const Matrix3& distortion);

// As in a recording's header: "mag" alone, or "mag1", "mag2", ...
std::vector<std::string> magnetometer_names(std::size_t count);

}  // namespace magimu
