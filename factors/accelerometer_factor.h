// SPDX-License-Identifier: BSD-3-Clause
// The accelerometer of a sensor that only turns: it reads gravity and its bias (first sum of the
// cost, Huang et al. 2025, eq. (original MAP)),
//
//   r = acc + C R' g - o_a        C = I for one sample.
//
// For the mean over a block of samples C is the mean of the rotations from the node to the samples
// (block_means.h): nothing is lost that decimation would throw away.
#pragma once

#include "factors/sensor_model.h"
#include "graph/factor_graph.h"

namespace magimu {

template <class S>
class AccelerometerText {
 public:
  AccelerometerText(const Vec3<S>& acc, const Vec3<S>& g_n) : acc_(acc), g_n_(g_n) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Vec3<T>& acc_bias) const {
    return acc_.template cast<T>() + nRb.unrotate(Vec3<T>(g_n_.template cast<T>())) - acc_bias;
  }

  // Appendix B: d r / d R = [R'g]x R' = R' [g]x,  d r / d o_a = -I.
  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Vec3<T>& acc_bias, Mat3<T>& J_R,
                    Mat3<T>& J_bias) const {
    const Vec3<T> g = g_n_.template cast<T>();
    const Mat3<T> bRn = nRb.matrix().transpose();
    J_R = bRn * so3::hat(g);
    J_bias = -Mat3<T>::Identity();
    return acc_.template cast<T>() + bRn * g - acc_bias;
  }

  static constexpr bool is_zero(int row, int column) { return column >= 3 && column % 3 != row; }

 private:
  Vec3<S> acc_, g_n_;
};

class AccelerometerFactor : public Factor<3, Rot3, Vector3>, public AccelerometerText<double> {
 public:
  template <class S>
  using Text = AccelerometerText<S>;

  // acc: m/s^2, IMU frame; g_n: gravity in n, for example gravity_n(9.80665).
  AccelerometerFactor(Key nRb, Key acc_bias, const Vector3& acc, const Vector3& g_n,
                      const Noise<3>& noise)
      : Factor({nRb, acc_bias}, noise), AccelerometerText(acc, g_n) {}
};
template <>
inline constexpr bool kHasLanes<AccelerometerFactor> = true;

template <class S>
class MeanAccelerometerText {
 public:
  MeanAccelerometerText(const Vec3<S>& acc, const Mat3<S>& C, const Vec3<S>& g_n)
      : acc_(acc), g_n_(g_n), C_(C) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Vec3<T>& acc_bias) const {
    return acc_.template cast<T>() +
           C_.template cast<T>() * nRb.unrotate(Vec3<T>(g_n_.template cast<T>())) - acc_bias;
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Vec3<T>& acc_bias, Mat3<T>& J_R,
                    Mat3<T>& J_bias) const {
    const Vec3<T> g = g_n_.template cast<T>();
    const Mat3<T> CbRn = C_.template cast<T>() * nRb.matrix().transpose();
    J_R = CbRn * so3::hat(g);
    J_bias = -Mat3<T>::Identity();
    return acc_.template cast<T>() + CbRn * g - acc_bias;
  }

  static constexpr bool is_zero(int row, int column) { return column >= 3 && column % 3 != row; }

 private:
  Vec3<S> acc_, g_n_;
  Mat3<S> C_;
};

class MeanAccelerometerFactor : public Factor<3, Rot3, Vector3>,
                                public MeanAccelerometerText<double> {
 public:
  template <class S>
  using Text = MeanAccelerometerText<S>;

  // acc: the block's mean; C: mean rotation from the node's IMU frame to that of the samples.
  MeanAccelerometerFactor(Key nRb, Key acc_bias, const Vector3& acc, const Matrix3& C,
                          const Vector3& g_n, const Noise<3>& noise)
      : Factor({nRb, acc_bias}, noise), MeanAccelerometerText(acc, C, g_n) {}
};
template <>
inline constexpr bool kHasLanes<MeanAccelerometerFactor> = true;

// Compiled once, in factors.cpp.
extern template class FactorBatchOf<AccelerometerFactor>;

}  // namespace magimu
