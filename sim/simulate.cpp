// SPDX-License-Identifier: BSD-3-Clause
// Motion and parameters in, measurements out: simulate.h.
#include "sim/simulate.h"

#include <cmath>

#include "factors/effects/noise_effects.h"
#include "recording/data/error.h"
#include "sim/draws/random.h"
#include "sim/effect_readings.h"
#include "sim/hand_room.h"
#include "sim/true_motion.h"

namespace magimu {
namespace {

void require(bool holds, const std::string& problem, const std::string& remedy) {
  if (!holds) throw InputError("simulate", 0, 0, problem, remedy);
}

void check(const SimulationOptions& o) {
  const auto non_negative = [](double x) { return std::isfinite(x) && x >= 0.0; };
  require(std::isfinite(o.rate_hz) && o.rate_hz >= 1.0, "the rate is below 1 Hz or not finite",
          "give the IMU's rate in Hz, such as 80");
  require(o.mag_ratio >= 1, "the magnetometer's ratio is below 1",
          "give the number of IMU samples per magnetometer sample, 1 or more");
  require(o.magnetometers >= 1, "no magnetometer", "ask for 1 or more");
  require(non_negative(o.duration_s), "the duration is negative or not finite",
          "give seconds, or 0 for the motion's own length");
  require(std::isfinite(o.rest_s), "the rest is not finite",
          "give seconds, or a negative number for the motion's own");
  require(o.duration_s == 0.0 || o.duration_s > o.rest_s, "the rest fills the whole duration",
          "ask for a longer duration or a shorter rest");
  require(std::isfinite(o.displacement_m), "the displacement is not finite",
          "give metres, or a negative number to have it drawn");
  require(non_negative(o.speed_mps), "the speed is negative or not finite", "give m/s, or 0");
  require(o.speed_mps == 0.0 || o.motion == SimulatedMotion::kHandHeld,
          "only the motion hand_held travels", "add --motion hand_held");
  require(std::isfinite(o.gravity), "gravity is not finite", "give m/s^2, such as 9.8");
  require(non_negative(o.noise_factor) && non_negative(o.noise.acc) && non_negative(o.noise.gyr) &&
              non_negative(o.noise.mag),
          "a noise density or the noise factor is negative or not finite",
          "give 0 for exact measurements");
}

// The requests resolved; linear_acceleration is the motion that it asks for.
std::vector<HiddenEffect> hide_all(SimulationOptions& o) {
  for (const EffectRequest& request : o.effects) {
    if (request.name == "linear_acceleration" && !o.follow) {
      o.motion = SimulatedMotion::kHandHeld;
    }
  }
  const double own = o.motion == SimulatedMotion::kPaper      ? paper_motion_duration_s()
                     : o.motion == SimulatedMotion::kSequence ? TurnSequence::kDuration
                                                              : HandMotion::kDuration;
  const SimulatedSurroundings where{o.seed, o.duration_s > 0.0 ? o.duration_s : own};
  std::vector<HiddenEffect> hidden;
  for (const EffectRequest& request : o.effects) {
    const HiddenEffect effect = hide(request, where);
    for (const HiddenEffect& other : hidden) {
      if (other.name != effect.name || other.channel != effect.channel) continue;
      throw InputError("--effect", 0, 0, effect.name + " is there twice", "give it once");
    }
    if (effect.name == "linear_acceleration") o.displacement_m = effect[0];
    hidden.push_back(effect);
  }
  return hidden;
}

// True seconds in a second of the file.
double clock_of(const std::vector<HiddenEffect>& effects) {
  for (const HiddenEffect& e : effects) {
    if (e.name == "clock_scale") return 1.0 + e[0];
  }
  return 1.0;
}

// Adds white noise of that density to every sample. Draws it even if the density is 0.
void add_white_noise(VectorSeries& series, double sigma, RandomStream random) {
  for (Vector3& sample : series.v) sample += sigma * random.normal3();
}

// The noise of one sensor, shaped where effects ask for it.
void add_sensor_noise(const SimulationOptions& o, const SimulationTruth& truth, Sensor channel,
                      std::size_t index, VectorSeries& series) {
  constexpr RandomPurpose kPurpose[] = {RandomPurpose::kAccelerometerNoise,
                                        RandomPurpose::kGyroscopeNoise,
                                        RandomPurpose::kMagnetometerNoise};
  const double densities[] = {truth.noise.acc, truth.noise.gyr, truth.noise.mag};
  const double rate = channel == Sensor::kMag ? o.rate_hz / o.mag_ratio : o.rate_hz;
  const double sigma = densities[int(channel)] * std::sqrt(rate);
  if (const auto shape = noise_shape(truth.effects, channel)) {
    RandomStream random(o.seed, RandomPurpose::kEffectNoise, std::uint64_t(channel) + 3 * index);
    add_noise(series.v, sigma, *shape, random.bits());
  } else {
    add_white_noise(series, sigma, {o.seed, kPurpose[int(channel)], index});
  }
}

void measure_imu(const TrueMotion& motion, const SimulationTruth& truth, Recording& recording) {
  const Vector3 g_n = gravity_n(truth.gravity);
  for (std::size_t k = 0; k < truth.t.size(); ++k) {
    // What accelerates the sensor adds to the reading like a gravity of the opposite sign.
    const Vector3 felt_n =
        motion.moves() ? Vector3(g_n - motion.acceleration(motion.time(k))) : g_n;
    recording.acc.push_back(truth.t[k],
                            accelerometer_model(truth.nRb[k], truth.parameters.acc_bias, felt_n));
    recording.gyr.push_back(truth.t[k], motion.mean_rate()[k] + truth.parameters.gyr_bias);
  }
}

VectorSeries measure_field(const SimulationOptions& o, const SimulationTruth& truth,
                           std::size_t index) {
  const MagnetometerParameters& mag = truth.parameters.mag[index];
  VectorSeries series;
  for (std::size_t k = 0; k < truth.t.size(); k += static_cast<std::size_t>(o.mag_ratio)) {
    series.push_back(truth.t[k], magnetometer_model(truth.nRb[k], mag.distortion, mag.bias,
                                                    truth.parameters.dip_rad));
  }
  return series;
}

// A field beside the Earth's, in n at a place and a time, as the magnetometers show it.
void add_field(const SimulationOptions& o, const TrueMotion& motion, const SimulationTruth& truth,
               const std::function<Vector3(const Vector3&, double)>& field_uT,
               Recording& recording) {
  require(motion.moves(), "a room shows only where the sensor moves about",
          "add --motion hand_held");
  for (std::size_t i = 0; i < recording.mag.size(); ++i) {
    const Matrix3 seen = truth.parameters.mag[i].distortion / truth.strength_uT;
    for (std::size_t k = 0; k < recording.mag[i].size(); ++k) {
      const double t = motion.time(k * std::size_t(o.mag_ratio));
      recording.mag[i].v[k] += seen * motion.attitude(t).unrotate(field_uT(motion.position(t), t));
    }
  }
}

void fill_truth(const SimulationOptions& o, const TrueMotion& motion, SimulationTruth& truth) {
  truth.parameters = o.device ? *o.device : draw_parameters(o.seed, o.magnetometers);
  truth.noise = {o.noise_factor * o.noise.acc, o.noise_factor * o.noise.gyr,
                 o.noise_factor * o.noise.mag};
  truth.gravity = o.gravity;
  truth.strength_uT = field_strength_uT(truth.parameters.mag.front().distortion);
  truth.nRb = motion.nRb();
  for (std::size_t k = 0; k < truth.nRb.size(); ++k) {
    truth.t.push_back(static_cast<double>(k) / o.rate_hz);
    if (!motion.moves()) continue;
    truth.p.push_back(motion.position(motion.time(k)));
    truth.v.push_back(motion.velocity(motion.time(k)));
  }
}

}  // namespace

std::string to_string(SimulatedMotion motion) {
  switch (motion) {
    case SimulatedMotion::kPaper:
      return "paper";
    case SimulatedMotion::kHand:
      return "hand";
    case SimulatedMotion::kHandHeld:
      return "hand_held";
    case SimulatedMotion::kSequence:
      return "sequence";
  }
  return "unknown";
}

Simulation simulate(const SimulationOptions& asked) {
  check(asked);
  SimulationOptions options = asked;
  Simulation simulation;
  SimulationTruth& truth = simulation.truth;
  Recording& recording = simulation.recording;
  truth.effects = hide_all(options);
  const TrueMotion motion(options, clock_of(truth.effects));
  fill_truth(options, motion, truth);
  recording.name =
      "simulation (" + to_string(options.motion) + ", seed " + std::to_string(options.seed) + ")";
  measure_imu(motion, truth, recording);
  recording.mag_names = magnetometer_names(truth.parameters.mag.size());
  for (std::size_t i = 0; i < truth.parameters.mag.size(); ++i) {
    recording.mag.push_back(measure_field(options, truth, i));
  }
  if (options.room) {
    const HandRoom room(*options.room, unit_field(truth.parameters.dip_rad), truth.t.back());
    add_field(
        options, motion, truth, [&](const Vector3& p, double t) { return room.field_uT(p, t); },
        recording);
  }
  if (options.field_of_place) {
    add_field(
        options, motion, truth, [&](const Vector3& p, double) { return options.field_of_place(p); },
        recording);
  }
  add_effects(options, motion, truth, recording);
  add_sensor_noise(options, truth, Sensor::kAcc, 0, recording.acc);
  add_sensor_noise(options, truth, Sensor::kGyr, 0, recording.gyr);
  for (std::size_t i = 0; i < recording.mag.size(); ++i) {
    add_sensor_noise(options, truth, Sensor::kMag, i, recording.mag[i]);
  }
  add_coupling(truth.effects, recording.mag);
  for (VectorSeries& mag : recording.mag) convert_to_digital(truth.effects, mag);
  MotionTruth& known = recording.truth.emplace();
  known.t = truth.t;
  known.nRb = truth.nRb;
  known.position = truth.p;
  known.valid.assign(truth.t.size(), true);
  return simulation;
}

}  // namespace magimu
