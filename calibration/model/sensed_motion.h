// SPDX-License-Identifier: BSD-3-Clause
// What the sensors of a recording experienced, sample by sample, as a fit has it: the arguments of
// the effects (factors/effects/effect.h). Wherever it can be it is what the fit estimates, not what
// a sensor read: estimates and residuals of a fit have no noise in common (Gauss and Markov), a
// reading and its residual do, and an effect made of one would be seen in the other.
#pragma once

#include <optional>

#include "calibration/model/model.h"
#include "calibration/motion/integrated_rotation.h"
#include "graph/values.h"

namespace magimu {

// The derivative of the rate at a time is the slope of a line through the gyroscope's readings so
// far about it: a hair more than 25 ms, at which those of 20 and 100 Hz lie, so that rounding
// does not decide which belong to it.
inline constexpr double kSlopeAround = 0.0255;  // s

class SensedMotion {
 public:
  // recording: with its readings corrected for the effects known so far. attitudes: false where
  // state() is asked for without them only.
  // All must outlive this.
  SensedMotion(const Recording& recording, const NodePlan& plan, const ModelSpec& spec,
               const Values& values, bool attitudes = true);

  // At a sample of a sensor (the first magnetometer).
  SampleState state(Sensor channel, std::size_t sample) const;
  // Time, specific force, temperature and current alone; of a moved sensor, whose accelerometer
  // reads its force (Effect::Description::without_attitude).
  SampleState state_without_attitude(Sensor channel, std::size_t sample) const;
  std::size_t samples(Sensor channel) const;

 private:
  const VectorSeries& series(Sensor channel) const;
  Rot3 before_gyr(double t) const;
  Rot3 attitude(double t) const;
  Vector3 beside_gyr(double t, const Rot3& nRb) const;
  Vector3 rate_about(double t, Vector3* derivative) const;
  Vector3 read_force(Sensor channel, std::size_t sample) const;
  double instant_of(Sensor channel, std::size_t sample) const;
  Vector3 force_change(double t, double delay_s) const;

  const Recording& recording_;
  const NodePlan& plan_;
  bool moving_;
  double gravity_;
  std::optional<IntegratedRotation> gyr_;  // nothing without attitudes
  Vector3 gyr_bias_, acc_bias_, mag_bias_, field_;
  Matrix3 D_;
  double delay_s_;                              // of the magnetometer
  double strength_, begin_, duration_, whole_;  // whole_: of all parts of the recording
  // Attitude of each node, relative to the gyroscope's at that time, and what it is to the next's.
  std::vector<Rot3> nodes_;
  std::vector<Vector3> steps_;
  ScalarSeries temperature_, current_;
  std::vector<Vector3> positions_;  // of each node, where the fit estimates them
  Vector3 position_mean_ = Vector3::Zero();
};

}  // namespace magimu
