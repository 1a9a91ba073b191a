// SPDX-License-Identifier: BSD-3-Clause
// The accelerometer of a sensor that only turns: it reads gravity and its bias (first sum of the
// cost, Huang et al. 2025, eq. (original MAP)),
//
//   r = acc + C R' g - o_a        C = I for one sample.
//
// For the mean over a block of samples C is the mean of the rotations from the node to the samples
// (block_mean.h): nothing is lost that decimation would throw away.
#pragma once

#include "factors/sensor_model.h"
#include "graph/factor_graph.h"

namespace magimu {

class AccelerometerFactor : public Factor<3, Rot3, Vector3> {
 public:
  // acc: m/s^2, IMU frame; g_n: gravity in n, for example gravity_n(9.80665).
  AccelerometerFactor(Key nRb, Key acc_bias, const Vector3& acc, const Vector3& g_n,
                      const Noise<3>& noise)
      : Factor({nRb, acc_bias}, noise), acc_(acc), g_n_(g_n) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Vec3<T>& acc_bias) const {
    return acc_.cast<T>() - accelerometer_model(nRb, acc_bias, g_n_);
  }

  // Appendix B: d r / d R = [R'g]x R' = R' [g]x,  d r / d o_a = -I.
  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Vec3<T>& acc_bias, Mat3<T>& J_R,
                    Mat3<T>& J_bias) const {
    const Vec3<T> g = g_n_.cast<T>();
    const Mat3<T> bRn = nRb.matrix().transpose();
    J_R = bRn * so3::hat(g);
    J_bias = -Mat3<T>::Identity();
    return acc_.cast<T>() + bRn * g - acc_bias;
  }

 private:
  Vector3 acc_, g_n_;
};

class MeanAccelerometerFactor : public Factor<3, Rot3, Vector3> {
 public:
  // acc: the block's mean; C: mean rotation from the node's IMU frame to that of the samples.
  MeanAccelerometerFactor(Key nRb, Key acc_bias, const Vector3& acc, const Matrix3& C,
                          const Vector3& g_n, const Noise<3>& noise)
      : Factor({nRb, acc_bias}, noise), acc_(acc), g_n_(g_n), C_(C) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Vec3<T>& acc_bias) const {
    return acc_.cast<T>() + C_.cast<T>() * nRb.unrotate(Vec3<T>(g_n_.cast<T>())) - acc_bias;
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Vec3<T>& acc_bias, Mat3<T>& J_R,
                    Mat3<T>& J_bias) const {
    const Vec3<T> g = g_n_.cast<T>();
    const Mat3<T> CbRn = C_.cast<T>() * nRb.matrix().transpose();
    J_R = CbRn * so3::hat(g);
    J_bias = -Mat3<T>::Identity();
    return acc_.cast<T>() + CbRn * g - acc_bias;
  }

 private:
  Vector3 acc_, g_n_;
  Matrix3 C_;
};

// Compiled once, in factors.cpp.
extern template class FactorBatchOf<AccelerometerFactor>;

}  // namespace magimu
