// SPDX-License-Identifier: BSD-3-Clause
// The rotation that the gyroscope alone predicts between any two times, in constant time each: one
// pass over the samples, each the mean rate over [t_k, t_k+1). Within that interval the rate
// changes as the neighbours' means say: a delay of a fraction of it is known as well as that.
#pragma once

#include "calibration/motion/effect_columns.h"
#include "factors/preintegrated_gyroscope.h"
#include "factors/preintegrated_imu.h"
#include "recording/data/recording.h"

namespace magimu {

class IntegratedRotation {
 public:
  // gyr: at least two samples; it must outlive this. bias: subtracted from every sample, rad/s.
  // matrix: the gyroscope's scale errors and misalignment S, gyr = (I + S) omega + bias.
  IntegratedRotation(const VectorSeries& gyr, const Vector3& bias,
                     const GyroMatrix& matrix = GyroMatrix::Zero());

  // Attitude at time t relative to that at the first sample; rates are held beyond both ends.
  Rot3 at(double t) const;
  // Rotation from the IMU frame at time b to that at time a.
  Rot3 between(double a, double b) const { return at(a).inverse() * at(b); }
  // Rate at time t, bias and matrix removed, rad/s.
  Vector3 rate(double t) const;
  // between(a, b) for a < b, with bias Jacobian and covariance; without a matrix. effects: of the
  // gyroscope's samples, null for none.
  PreintegratedGyroscope preintegrate(double a, double b,
                                      const EffectColumns* effects = nullptr) const;
  // The same with the accelerometer, each of whose samples is held from half a sample before its
  // time to half a sample after.
  // with_matrix: the matrix is unknown, and its Jacobian is wanted.
  PreintegratedImu preintegrate(double a, double b, const VectorSeries& acc,
                                const Vector3& acc_bias, bool with_matrix,
                                const EffectColumns* gyr_effects = nullptr,
                                const EffectColumns* acc_effects = nullptr) const;

 private:
  std::size_t sample_at(double t) const;
  Vector3 rate_of(std::size_t k) const { return unscale_ * (gyr_.v[k] - bias_); }
  Vector3 slope_of(std::size_t k) const;
  Vector3 reading_of(std::size_t k, double a, double b) const;

  const VectorSeries& gyr_;
  Vector3 bias_;
  GyroMatrix matrix_;           // S
  Matrix3 unscale_;             // (I + S)^-1
  std::vector<Rot3> attitude_;  // at each sample's time
};

}  // namespace magimu
