// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/choose_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/fit/held_out.h"
#include "calibration/motion/rests/rests.h"

namespace magimu {
namespace {

constexpr double kSwung = 4.0,
                 kSwungColour = 0.5;  // beyond these gravity and a bias explain nothing
constexpr double kColour = 0.2;       // correlation of neighbouring accelerometer residuals

// What speaks for a moved hand, of the accelerometer and of the left-out magnetometer.
std::string grounds_of_motion(double excess, double colour, const AccNoise& noise,
                              const HeldOutGain& gain) {
  std::string out =
      fmt::format("under pure rotation the accelerometer's residual is {:.1f} times {}", excess,
                  noise.at_rest ? "its noise at rest"
                                : "the noise of the noisiest parts (no rest shows its own)");
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

AccNoise largest_acc_noise(const std::vector<const Recording*>& recordings, double rest_acc) {
  if (rest_acc > 0.0) return {rest_acc, true};
  AccNoise out;
  for (const Recording* r : recordings) out.density = std::max(out.density, noisiest_acc(r->acc));
  return out;
}

MotionChoice choose_motion(const Stage& rotation, const Stage& hand_held, const AccNoise& noise) {
  const HeldOutGain gain = held_out_gain(rotation, hand_held);
  const SensorSums sums = rotation.sums();
  const double colour = sums.lag1[std::size_t(Sensor::kAcc)];
  const double density = rotation.spec().noise.acc * sums.rms(Sensor::kAcc);
  const double excess = density / noise.density;
  MotionChoice choice;
  const bool restless = excess > kExcessNoise || colour > kColour;
  const bool swung = excess > kSwung || colour > kSwungColour;
  if (swung || gain.better() || (restless && !gain.worse())) {
    choice.motion = MotionModel::kHandHeld;
    choice.reason =
        "The hand moved the sensor: " + grounds_of_motion(excess, colour, noise, gain) + ".";
  } else {
    choice.motion = MotionModel::kRotation;
    choice.reason = fmt::format(
        "The sensor only turned: the accelerometer reads gravity to {} (correlation {:.2f}), and "
        "modelling a motion does not predict the left-out magnetometer better (ratio {:.2f}).",
        noise.at_rest
            ? fmt::format("{:.1f} times its noise", excess)
            : fmt::format("{:.2g} m/s^2/sqrt(Hz), which is noise that parts have", density),
        colour, gain.ratio());
  }
  return choice;
}

}  // namespace magimu
