// SPDX-License-Identifier: BSD-3-Clause
// What the other sensors say while one sensor repeats a reading or jumps: whether the device
// turned. The gyroscope shows it, or gravity and the field together, as each of these alone may be
// shaken or disturbed. (Against an accelerometer that hangs the field alone counts.) Medians and
// quantiles, so that no single reading decides. Internal to the gate.
#pragma once

#include "recording/oddities/sensor_gate.h"

namespace magimu {

class GateWitnesses {
 public:
  // The recording must outlive this.
  explicit GateWitnesses(const Recording& recording);

  bool turned(Sensor hung, double begin_s, double end_s) const;
  // Whether gravity and the field agree that the rate was larger by `more` (rad/s, in the device's
  // axes) between these times than before and after. By the Bayes factor against a wrong reading of
  // the gyroscope.
  bool turned_by(double begin_s, double end_s, const Vector3& more) const;
  // Whether most readings of another sensor differ from the reading before.
  bool others_change(Sensor hung, double begin_s, double end_s) const;

 private:
  const Recording& recording_;
  double usual_rate_;  // rad/s: the rate that the fastest tenth of all samples exceeds
};

}  // namespace magimu
