// SPDX-License-Identifier: BSD-3-Clause
// The rotation that the gyroscope alone predicts between any two times, in constant time each: one
// pass over the samples, each rate held over [t_k, t_k+1).
#pragma once

#include "factors/preintegrated_gyroscope.h"
#include "factors/preintegrated_imu.h"
#include "recording/recording.h"

namespace magimu {

class IntegratedRotation {
 public:
  // gyr: at least two samples; it must outlive this. bias: subtracted from every sample, rad/s.
  IntegratedRotation(const VectorSeries& gyr, const Vector3& bias);

  // Attitude at time t relative to that at the first sample; rates are held beyond both ends.
  Rot3 at(double t) const;
  // Rotation from the IMU frame at time b to that at time a.
  Rot3 between(double a, double b) const { return at(a).inverse() * at(b); }
  // Rate at time t, bias removed, rad/s.
  Vector3 rate(double t) const { return gyr_.v[sample_at(t)] - bias_; }
  // between(a, b) for a < b, with bias Jacobian and covariance.
  PreintegratedGyroscope preintegrate(double a, double b) const;
  // The same with the accelerometer, each of whose samples is held from half a sample before its
  // time to half a sample after; densities per sqrt(Hz).
  PreintegratedImu preintegrate(double a, double b, const VectorSeries& acc,
                                const Vector3& acc_bias, double gyr_density,
                                double acc_density) const;

 private:
  std::size_t sample_at(double t) const;

  const VectorSeries& gyr_;
  Vector3 bias_;
  std::vector<Rot3> attitude_;  // at each sample's time
};

}  // namespace magimu
