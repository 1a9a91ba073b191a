// SPDX-License-Identifier: BSD-3-Clause
// Recordings of one device as a factor graph, under one of three models of the motion:
//
//   rotation   the sensor only turns (the paper's): nodes R; the accelerometer reads gravity
//   hand_held  a hand moves it within its reach: nodes R, v, p; accelerometer and gyroscope are
//              integrated between nodes, and all that is assumed of the motion is that the position
//              stays within a bound, a weak measurement of p every three seconds
//   travelling it walks, rides or flies: the same nodes, with a bound on the velocity instead
//
// In all three, a node stands at a magnetometer sample (every one, or every n-th with all samples
// averaged in blocks about the nodes). Biases and distortion are shared; each recording has its
// own dip.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "calibration/motion/nodes.h"
#include "factors/effects/effect.h"
#include "factors/preintegrated_imu.h"
#include "factors/sensor_model.h"
#include "graph/factor_graph.h"

namespace magimu {

struct ExtendedRecording;

enum class MotionModel { kAuto, kRotation, kHandHeld, kTravelling };
std::string to_string(MotionModel motion);
// Does the model have nodes R, v, p? Otherwise the sensor only turns.
constexpr bool is_moved(MotionModel motion) {
  return motion == MotionModel::kHandHeld || motion == MotionModel::kTravelling;
}

constexpr double kReachEvery = 3.0;          // s between weak measurements of position or velocity
constexpr double kLeverArmPriorSigma = 0.5;  // m, of each axis: a forearm, a stick, a robot's arm
constexpr double kLongestArm = 2.0;          // m: four of these; a longer one is no hand's
constexpr double kOwnVelocityPriorSigma = 10.0;  // m/s, of each axis: walks, vehicles in town
// m: limits of the standard deviation of the point that a hand turns the sensor about. An arm
// reaches 0.7 m to either side; a point that is anywhere in there with the same probability has 0.4
// m. A wider limit lets the estimate wander off by tens of metres where gravity and an uneven field
// disagree, instead of holding the tilt by gravity.
constexpr double kMinReach = 0.1, kMaxReach = 0.4;
constexpr double kMinSpeed = 0.1, kMaxSpeed = 100.0;  // m/s: the same of a travelling speed

// What a graph is built from, besides the recordings.
struct ModelSpec {
  MotionModel motion = MotionModel::kRotation;  // not kAuto
  NoiseDensities noise;                         // per sqrt(Hz)
  // Of each magnetometer of an array, uT per sqrt(Hz), where each has its own; noise.mag is then
  // the first one's. Empty: noise.mag of all.
  std::vector<double> mag_noise;
  double reach_m = 0.3;  // hand_held: sigma of the point that the sensor is turned about
  // travelling: sigma of v - R u, each axis, m/s, with u a steady velocity along the sensor's own
  // axes that is estimated (a vehicle moves forward); and the time between two weak measurements of
  // v - R u = 0, s, so long that they are independent.
  double speed_mps = 2.0, velocity_every_s = kReachEvery;
  double acc_jitter = 0.0;  // moved: how far off in time, in sampling intervals (acc_jitter.h)
  double gravity = kStandardGravity;  // m/s^2
  bool mag_time_offset = false;       // a lag of each magnetometer is unknown, too
  bool gyr_matrix = false;            // moved: the gyroscope's scale errors and misalignment, too
  // Where samples are integrated and means taken: the values of these variables expected.
  Vector3 gyr_bias = Vector3::Zero(), acc_bias = Vector3::Zero();
  GyroMatrix gyr_matrix_value = GyroMatrix::Zero();
  std::vector<double> mag_offset_s;  // one a magnetometer
  // Model extensions, and the recordings corrected for them where the parameters stand now, one a
  // recording (extension.h); none without effects.
  std::vector<std::shared_ptr<const Effect>> effects;
  std::vector<std::shared_ptr<const ExtendedRecording>> extended;
  // Nodes without their magnetometers, for cross-validation; empty: all have them.
  std::function<bool(int node)> without_mag;
  // Which bias a node's magnetometers have, where a change was recognised: key::mag_bias_of(m,
  // earlier); empty: 0, the same throughout.
  std::function<int(int node)> earlier_bias;
  // Moved: the nodes whose position (travelling: velocity) is weakly measured; empty: one every
  // kReachEvery (velocity_every_s).
  std::function<bool(int node)> reach_at;
  // Sampling rates, Hz; 0: those of the recording's samples.
  double acc_rate_hz = 0.0, mag_rate_hz = 0.0;
  // Adds further factors, such as priors that hold parameters where they are known; empty: none.
  std::function<void(FactorGraph&)> also;
};

// The density of one magnetometer's noise, uT per sqrt(Hz).
double mag_density(const ModelSpec& spec, int magnetometer);

// From the effect widened_from on, priors are wider by that factor. A plan that continues another
// part's brings no priors: they came with the first part.
FactorGraph build_model(const std::vector<const Recording*>& recordings,
                        const std::vector<NodePlan>& plans, const ModelSpec& spec,
                        int widened_from = 1 << 30, double widening = 1.0);

}  // namespace magimu
