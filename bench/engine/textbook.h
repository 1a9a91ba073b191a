// SPDX-License-Identifier: BSD-3-Clause
// What a good engineer writes for exactly one problem, to measure the library against: Gauss-Newton
// for one recording of a sensor that only turns (Huang et al. 2025, eq. (original MAP)), a pose at
// every sample, 19 parameters. The normal equations are a chain of 3x3 blocks with a border of 19
// columns; one pose after the other is linearized and eliminated by Cholesky, then the parameters
// are solved for, then the poses backwards. No factors, keys or sparse matrices, and no damping.
//
//   Textbook textbook(data, start);
//   while (textbook.iterate() > 1e-6) {
//   }
#pragma once

#include <vector>

#include "graph/rot3.h"

namespace magimu {

// Poses at the samples' times; gyr[k] is the mean rate from pose k to pose k + 1.
struct RotationData {
  std::vector<Vector3> acc, gyr, mag;                        // m/s^2, rad/s, uT
  double dt_s = 0.0;                                         // between two poses
  Vector3 g_n = Vector3::Zero();                             // gravity, m/s^2
  double acc_sigma = 0.0, gyr_sigma = 0.0, mag_sigma = 0.0;  // of one sample
};

struct RotationUnknowns {
  std::vector<Rot3> nRb;
  Vector3 acc_bias, gyr_bias, mag_bias;
  Matrix3 distortion;
  double dip_rad = 0.0;
};

class Textbook {
 public:
  // data must outlive this.
  Textbook(const RotationData& data, const RotationUnknowns& start);

  // One Gauss-Newton step. Returns its length |dx|, all units together; not a number where the
  // normal equations are not positive definite.
  double iterate();
  const RotationUnknowns& unknowns() const { return x_; }

 private:
  static constexpr int kGlobals = 19;
  using Globals = Vec<double, kGlobals>;
  // What the normal equations hold in the rows of one pose; once it is eliminated, L and L^-1 times
  // the rest.
  struct PoseRows {
    Matrix3 own = Matrix3::Zero(), next = Matrix3::Zero();
    Mat<double, 3, kGlobals> globals = Mat<double, 3, kGlobals>::Zero();
    Vector3 gradient = Vector3::Zero();
  };

  void add_accelerometer(std::size_t k);
  void add_magnetometer(std::size_t k);
  void add_gyroscope(std::size_t k);
  void eliminate(std::size_t k);
  double step_back();

  const RotationData& data_;
  RotationUnknowns x_;
  Vector3 field_n_, field_change_;  // unit field in n, and its derivative by the dip
  std::vector<PoseRows> rows_;
  Mat<double, kGlobals, kGlobals> root_;
  Globals root_gradient_;
};

}  // namespace magimu
