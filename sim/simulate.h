// SPDX-License-Identifier: BSD-3-Clause
// A recording made from a known truth: a sensor that turns, on the spot or moved about by the hand,
// its parameters drawn from
// Table I of Huang et al. 2025, and the measurement models of factors/sensor_model.h with white
// noise added. By default it is the data set of the paper's simulation study.
//
//   SimulationOptions options;
//   options.motion = SimulatedMotion::kHand;
//   const Simulation simulation = simulate(options);
//   // calibrate simulation.recording, compare with simulation.truth.parameters
//
// Sample k of the IMU is at t_k = k / rate_hz, its gyroscope value the mean rate over
// [t_k, t_k+1); the magnetometers have every mag_ratio-th of these times, from the first on. The
// same options give the same bits wherever the mathematical library does.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "factors/sensor_model.h"
#include "graph/rot3.h"
#include "recording/data/recording.h"
#include "sim/draws/parameters.h"
#include "sim/hidden_effects.h"
#include "sim/motions/followed_motion.h"

namespace magimu {

enum class SimulatedMotion {
  kPaper,     // six slow turns about fixed axes: motion.h
  kHand,      // a board turned in the hands, with rests: hand_motion.h
  kHandHeld,  // the same at a varied pace, and moved about within reach: hand_displacement.h
  kSequence,  // the sequence of half turns that the paper recommends: turn_sequence.h
};

// As on the command line: "paper", "hand", "hand_held", "sequence".
std::string to_string(SimulatedMotion motion);

struct SimulationOptions {
  SimulatedMotion motion = SimulatedMotion::kPaper;
  // Of the IMU, Hz, at least 1. kHand is one motion at any rate; kPaper draws its rate anew in
  // every step, so that it is another one.
  double rate_hz = 80.0;
  // IMU samples per magnetometer sample. A slower magnetometer has less noise a sample: it is the
  // density that stays.
  int mag_ratio = 1;
  // Length of the recording, s, rests included. 0: the motion's own length: after the first rest
  // six nominal turns for kPaper (322 s), 117 s for kHand, 60 s for kSequence.
  double duration_s = 0.0;
  // Names the data set: parameters, motion and noise each draw from streams of their own.
  std::uint64_t seed = 1;
  double gravity = kPaperGravity;      // g0, m/s^2
  NoiseDensities noise = kPaperNoise;  // m/s^2, rad/s, uT, per sqrt(Hz)
  double noise_factor = 1.0;           // multiplies all three densities; 0: exact measurements
  int magnetometers = 1;               // of one device, rigidly joined
  // At rest before the first movement, s. Negative: the motion's own, 0 for kPaper (its data start
  // moving) and 3 s for the others.
  double rest_s = -1.0;
  // kHandHeld: root mean square of the displacement while the hand moves, m. Negative: drawn from
  // 0.05 to 0.30.
  double displacement_m = -1.0;
  // kHandHeld: root mean square of the speed, m/s, at which the bearer of the sensor travels
  // besides (travelled_path.h). 0: the bearer stays.
  double speed_mps = 0.0;
  // What the sensor models leave out; the magnetometers all have the same of it. In this order:
  // terms, noise, quantization, clipping. linear_acceleration makes the motion kHandHeld.
  std::vector<EffectRequest> effects;
  // A room about a sensor that is moved about (hand_room.h), named by this seed; none: a field that
  // is the same everywhere.
  std::optional<std::uint64_t> room;
  // A field beside the Earth's that differs from place to place, uT in n at a place of the motion;
  // none: there is none.
  std::function<Vector3(const Vector3& place)> field_of_place;
  // A replica: this motion instead of one of the above, and this device instead of a drawn one.
  std::shared_ptr<const EstimatedTrajectory> follow;
  std::optional<SensorParameters> device;
};

struct SimulationTruth {
  SensorParameters parameters;
  NoiseDensities noise;  // as in the measurements: times noise_factor, so 0 where they are exact
  double gravity = 0.0;  // m/s^2
  double strength_uT = 0.0;   // cube root of det D of the first magnetometer
  std::vector<double> t;      // s, the IMU's sample times
  std::vector<Rot3> nRb;      // attitude at these times
  std::vector<Vector3> v, p;  // velocity m/s, position m, in n; empty: the sensor only turns
  std::vector<HiddenEffect> effects;
  std::vector<Vector3> gyr_bias_drift;  // at these times, rad/s; empty without it
};

struct Simulation {
  Recording recording;  // with the truth of the motion in recording.truth
  SimulationTruth truth;
};

// Throws InputError where an option is out of its range.
Simulation simulate(const SimulationOptions& options);

}  // namespace magimu
