// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/choose_motion.h"

#include <fmt/format.h>

#include "calibration/fit/held_out.h"

namespace magimu {
namespace {

constexpr double kExcessNoise = 1.3;  // accelerometer noise in motion over that at rest
constexpr double kSwung = 4.0,
                 kSwungColour = 0.5;  // beyond these gravity and a bias explain nothing
constexpr double kColour = 0.2;       // correlation of neighbouring accelerometer residuals

// What speaks for a moved hand, of the accelerometer and of the left-out magnetometer.
std::string grounds_of_motion(double excess, double colour, const HeldOutGain& gain) {
  std::string out = fmt::format(
      "under pure rotation the accelerometer's residual is {:.1f} times its noise at rest", excess);
  if (excess <= kExcessNoise && colour > kColour) {
    out = fmt::format(
        "under pure rotation neighbouring residuals of the accelerometer are alike (correlation "
        "{:.2f})",
        colour);
  } else if (excess <= kExcessNoise) {
    out = "the accelerometer alone does not show it";
  }
  out += ", and the magnetometer, where left out, is predicted ";
  if (!gain.better()) return out + "no worse once the motion is modelled";
  return out + fmt::format("{:.2f} times as well once the motion is modelled", gain.ratio());
}

}  // namespace

MotionChoice choose_motion(const Stage& rotation, const Stage& hand_held, double rest_acc) {
  const HeldOutGain gain = held_out_gain(rotation, hand_held);
  const SensorSums sums = rotation.sums();
  const double colour = sums.lag1[std::size_t(Sensor::kAcc)];
  const double excess =
      rest_acc > 0.0 ? rotation.spec().noise.acc * sums.rms(Sensor::kAcc) / rest_acc : 1.0;
  MotionChoice choice;
  const bool restless = excess > kExcessNoise || colour > kColour;
  const bool swung = excess > kSwung || colour > kSwungColour;
  if (swung || gain.better() || (restless && !gain.worse())) {
    choice.motion = MotionModel::kHandHeld;
    choice.reason = "The hand moved the sensor: " + grounds_of_motion(excess, colour, gain) + ".";
  } else {
    choice.motion = MotionModel::kRotation;
    choice.reason = fmt::format(
        "The sensor only turned: the accelerometer reads gravity to {:.1f} times its noise "
        "(correlation {:.2f}), and modelling a motion does not predict the left-out magnetometer "
        "better (ratio {:.2f}).",
        excess, colour, gain.ratio());
  }
  return choice;
}

}  // namespace magimu
