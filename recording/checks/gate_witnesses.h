// SPDX-License-Identifier: BSD-3-Clause
// Whether the device turned while one of its sensors read the same all the time, as the other
// sensors say: rates, or gravity and the field together, for each alone may be shaken or disturbed
// (an accelerometer that does not even show its noise needs the field alone). Medians and
// quantiles, so that no single reading counts. Internal to the gate.
#pragma once

#include "recording/checks/sensor_gate.h"

namespace magimu {

class GateWitnesses {
 public:
  // The recording must outlive this.
  explicit GateWitnesses(const Recording& recording);

  bool turned(SensorGate::Sensor hung, double begin_s, double end_s) const;
  // Whether gravity and the field say that the device turned at so much more, rad/s in its own
  // axes, than before and after: by Bayes' factor against a gyroscope that read what was not.
  bool turned_by(double begin_s, double end_s, const Vector3& more) const;
  // Most readings of another sensor differ from the one before.
  bool others_change(SensorGate::Sensor hung, double begin_s, double end_s) const;

 private:
  const Recording& recording_;
  double usual_rate_;  // rad/s, of the fastest tenth, at least
};

}  // namespace magimu
