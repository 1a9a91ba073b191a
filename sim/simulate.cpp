// SPDX-License-Identifier: BSD-3-Clause
// Motion and parameters in, measurements out: simulate.h.
#include "sim/simulate.h"

#include <cmath>

#include "recording/error.h"
#include "sim/hand_displacement.h"
#include "sim/hand_motion.h"
#include "sim/motion.h"
#include "sim/random.h"

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
  require(std::isfinite(o.gravity), "gravity is not finite", "give m/s^2, such as 9.8");
  require(non_negative(o.noise_factor) && non_negative(o.noise.acc) && non_negative(o.noise.gyr) &&
              non_negative(o.noise.mag),
          "a noise density or the noise factor is negative or not finite",
          "give 0 for exact measurements");
}

AngularMotion make_motion(const SimulationOptions& o, SimulationTruth& truth,
                          std::vector<Vector3>& acceleration) {
  const bool paper = o.motion == SimulatedMotion::kPaper;
  const double rest = o.rest_s >= 0.0 ? o.rest_s : paper ? 0.0 : HandMotion::kRest;
  const double moving =
      paper ? paper_motion_duration_s() : HandMotion::kDuration - HandMotion::kRest;
  const double duration = o.duration_s > 0.0 ? o.duration_s : rest + moving;
  if (paper) return paper_motion(o.seed, o.rate_hz, duration, rest);
  const bool moved = o.motion == SimulatedMotion::kHandHeld;
  const HandMotion hand(o.seed, duration, rest, moved);
  if (moved) {
    const HandDisplacement path(o.seed, hand.stretches(), o.displacement_m);
    for (std::size_t k = 0; k < sample_count(duration, o.rate_hz); ++k) {
      const double t = static_cast<double>(k) / o.rate_hz;
      truth.p.push_back(path.position(t));
      truth.v.push_back(path.velocity(t));
      acceleration.push_back(path.acceleration(t));
    }
  }
  return sample_motion(
      hand.initial_nRb(), [&](double t) { return hand.omega(t); }, o.rate_hz, duration);
}

// Adds white noise of that density to every sample. Draws it even if the density is 0.
void add_noise(VectorSeries& series, double density, double rate_hz, RandomStream random) {
  const double sigma = density * std::sqrt(rate_hz);
  for (Vector3& sample : series.v) sample += sigma * random.normal3();
}

void measure_imu(const SimulationOptions& o, const SimulationTruth& truth,
                 const std::vector<Vector3>& mean_rate, const std::vector<Vector3>& acceleration,
                 Recording& recording) {
  const Vector3 g_n = gravity_n(truth.gravity);
  for (std::size_t k = 0; k < truth.t.size(); ++k) {
    // What accelerates the sensor adds to the reading like a gravity of the opposite sign.
    const Vector3 felt_n = acceleration.empty() ? g_n : Vector3(g_n - acceleration[k]);
    recording.acc.push_back(truth.t[k],
                            accelerometer_model(truth.nRb[k], truth.parameters.acc_bias, felt_n));
    recording.gyr.push_back(truth.t[k], mean_rate[k] + truth.parameters.gyr_bias);
  }
  add_noise(recording.acc, truth.noise.acc, o.rate_hz,
            {o.seed, RandomPurpose::kAccelerometerNoise});
  add_noise(recording.gyr, truth.noise.gyr, o.rate_hz, {o.seed, RandomPurpose::kGyroscopeNoise});
}

VectorSeries measure_field(const SimulationOptions& o, const SimulationTruth& truth,
                           std::size_t index) {
  const MagnetometerParameters& mag = truth.parameters.mag[index];
  VectorSeries series;
  for (std::size_t k = 0; k < truth.t.size(); k += static_cast<std::size_t>(o.mag_ratio)) {
    series.push_back(truth.t[k], magnetometer_model(truth.nRb[k], mag.distortion, mag.bias,
                                                    truth.parameters.dip_rad));
  }
  add_noise(series, truth.noise.mag, o.rate_hz / o.mag_ratio,
            {o.seed, RandomPurpose::kMagnetometerNoise, index});
  return series;
}

void fill_truth(const SimulationOptions& o, const AngularMotion& motion, SimulationTruth& truth) {
  truth.parameters = draw_parameters(o.seed, o.magnetometers);
  truth.noise = {o.noise_factor * o.noise.acc, o.noise_factor * o.noise.gyr,
                 o.noise_factor * o.noise.mag};
  truth.gravity = o.gravity;
  truth.strength_uT = field_strength_uT(truth.parameters.mag.front().distortion);
  truth.nRb = integrate(motion, o.rate_hz);
  for (std::size_t k = 0; k < truth.nRb.size(); ++k) {
    truth.t.push_back(static_cast<double>(k) / o.rate_hz);
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
  }
  return "unknown";
}

Simulation simulate(const SimulationOptions& options) {
  check(options);
  Simulation simulation;
  SimulationTruth& truth = simulation.truth;
  Recording& recording = simulation.recording;
  std::vector<Vector3> acceleration;  // in n, m/s^2; empty: the sensor only turns
  const AngularMotion motion = make_motion(options, truth, acceleration);
  fill_truth(options, motion, truth);
  recording.name =
      "simulation (" + to_string(options.motion) + ", seed " + std::to_string(options.seed) + ")";
  measure_imu(options, truth, motion.mean_rate, acceleration, recording);
  recording.mag_names = magnetometer_names(truth.parameters.mag.size());
  for (std::size_t i = 0; i < truth.parameters.mag.size(); ++i) {
    recording.mag.push_back(measure_field(options, truth, i));
  }
  MotionTruth& known = recording.truth.emplace();
  known.t = truth.t;
  known.nRb = truth.nRb;
  known.position = truth.p;
  known.valid.assign(truth.t.size(), true);
  return simulation;
}

}  // namespace magimu
