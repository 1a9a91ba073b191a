// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/choose_motion.h"

#include <fmt/format.h>

#include <cmath>

namespace magimu {
namespace {

constexpr double kBlock = 5.0;        // s left out at a time
constexpr double kExcessNoise = 1.3;  // accelerometer noise in motion over that at rest
constexpr double kSwung = 4.0,
                 kSwungColour = 0.5;  // beyond these gravity and a bias explain nothing
constexpr double kColour = 0.2;       // correlation of neighbouring accelerometer residuals

// The block that each node's time falls into; blocks of all recordings are numbered through.
std::vector<int> blocks_of(const std::vector<NodePlan>& plans) {
  std::vector<int> out;
  int first = 0;
  for (const NodePlan& plan : plans) {
    int last = first;
    for (const double t : plan.t) {
      last = first + int((t - plan.t.front()) / kBlock);
      out.push_back(last);
    }
    first = last + 1;
  }
  return out;
}

// Squared magnetometer errors, uT^2, summed over each block, predicted without that block's.
std::vector<double> held_out_squares(Stage stage, const std::vector<int>& block) {
  std::vector<double> out(std::size_t(block.back()) + 1, 0.0);
  const Values optimum = stage.result().values;
  const double scale = std::pow(stage.spec().noise.mag, 2);
  for (const int parity : {0, 1}) {
    stage.fit_without(optimum, [&](int node) { return block[std::size_t(node)] % 2 == parity; });
    const std::vector<double> squares = stage.mag_squares();
    for (std::size_t i = 0; i < squares.size(); ++i) {
      if (block[i] % 2 == parity) out[std::size_t(block[i])] += squares[i] * scale;
    }
  }
  return out;
}

}  // namespace

MotionChoice choose_motion(const Stage& rotation, const Stage& hand_held, double rest_acc) {
  const std::vector<int> block = blocks_of(rotation.plans());
  const std::vector<double> turned = held_out_squares(rotation, block);
  const std::vector<double> moved = held_out_squares(hand_held, block);
  // Mean difference of log errors over blocks, with its standard error.
  double sum = 0.0, sum2 = 0.0;
  const auto n = double(turned.size());
  for (std::size_t b = 0; b < turned.size(); ++b) {
    const double d = std::log(std::max(turned[b], 1e-30) / std::max(moved[b], 1e-30));
    sum += d;
    sum2 += d * d;
  }
  const double mean = sum / n;
  const double error = std::sqrt(std::max(1e-12, sum2 / n - mean * mean) / n);
  const double ratio = std::exp(0.5 * mean);
  const SensorSums sums = rotation.sums();
  const double colour = sums.lag1[std::size_t(Sensor::kAcc)];
  const double excess =
      rest_acc > 0.0 ? rotation.spec().noise.acc * sums.rms(Sensor::kAcc) / rest_acc : 1.0;
  MotionChoice choice;
  const bool predicts_better = mean > 2.0 * error && ratio > 1.02;
  const bool restless = excess > kExcessNoise || colour > kColour;
  const bool clearly_worse = mean < -2.0 * error && ratio < 0.98;
  const bool swung = excess > kSwung || colour > kSwungColour;
  if (swung || predicts_better || (restless && !clearly_worse)) {
    choice.motion = MotionModel::kHandHeld;
    choice.reason = fmt::format(
        "The hand moved the sensor: under pure rotation the accelerometer's residual is {:.1f} "
        "times its noise at rest (correlation {:.2f}), and the magnetometer, where left out, is "
        "predicted {:.2f} times as well once the motion is modelled.",
        excess, colour, ratio);
  } else {
    choice.motion = MotionModel::kRotation;
    choice.reason = fmt::format(
        "The sensor only turned: the accelerometer reads gravity to {:.1f} times its noise "
        "(correlation {:.2f}), and modelling a motion does not predict the left-out magnetometer "
        "better (ratio {:.2f}).",
        excess, colour, ratio);
  }
  return choice;
}

}  // namespace magimu
