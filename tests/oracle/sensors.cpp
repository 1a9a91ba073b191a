// SPDX-License-Identifier: BSD-3-Clause
// A recording from a motion, a device and effects: sensors.h.
#include "tests/oracle/sensors.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/oracle/degrade.h"
#include "tests/oracle/mag_model.h"

namespace magimu::oracle {
namespace {

void check(const Options& o) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(what);
  };
  require(o.rate_hz >= 1.0 && o.rate_hz <= 4000.0, "oracle: rate_hz is not from 1 to 4000");
  require(o.mag_rate_hz >= 0.0 && o.mag_first_s >= 0.0, "oracle: negative magnetometer times");
  require(o.motion.duration_s * o.rate_hz >= 2.0, "oracle: the recording has no samples");
  require(o.motion.rest_s >= 0.0 && o.motion.pause_s >= 0.0, "oracle: negative rests");
  require(o.noise_factor >= 0.0, "oracle: negative noise_factor");
}

// first, first + 1 / rate, ... before `end`
std::vector<double> sample_times(double first, double rate_hz, double end) {
  std::vector<double> t;
  for (std::size_t k = 0;; ++k) {
    t.push_back(first + static_cast<double>(k) / rate_hz);
    if (t.back() < end - 1e-9) continue;
    t.pop_back();
    return t;
  }
}

double clock_scale(const std::vector<Effect>& effects) {
  double kappa = 0.0;
  for (const Effect& e : effects) kappa += e.kind == EffectKind::kClockScale ? e[0] : 0.0;
  return kappa;
}

std::vector<double> scaled(std::vector<double> t, double factor) {
  for (double& x : t) x *= factor;
  return t;
}

VectorSeries series(const std::vector<double>& t, std::vector<Vector3d> values, Channel channel,
                    double density, double rate_hz, const Options& o) {
  degrade(values, channel, o.noise_factor * density * std::sqrt(rate_hz), o.effects, o.seed);
  return {t, std::move(values)};
}

void add_columns(const Options& o, const Truth& truth, const std::vector<double>& true_t,
                 Recording& recording) {
  if (o.record_pos) recording.pos = VectorSeries{truth.t, truth.p};
  for (const auto& [name, wanted, profile] :
       {std::tuple("temp", o.record_temp, &o.temperature),
        std::tuple("current", o.record_current, &o.current)}) {
    if (!wanted) continue;
    ScalarSeries& column = recording.aux[name];
    column.t = truth.t;
    for (std::size_t k = 0; k < truth.t.size(); ++k) column.v.push_back((*profile)(true_t[k]));
  }
}

void follow(const Motion& motion, const std::vector<double>& true_t, Truth& truth) {
  for (std::size_t k = 0; k < truth.t.size(); ++k) {
    const Quaterniond q = motion.nRb(true_t[k]);
    truth.nRb.push_back(Rot3::from_unit_quaternion({q.w(), q.x(), q.y(), q.z()}));
    truth.v.push_back(motion.velocity(true_t[k]));
    truth.p.push_back(motion.position(true_t[k]));
  }
}

}  // namespace

double warming_up(double t) {
  return 304.0 - 8.0 * std::exp(-t / 45.0) + 0.4 * std::sin(2.0 * std::numbers::pi * t / 37.0);
}

double switching_current(double t) {
  const double phase = t - 7.0 * std::floor(t / 7.0);
  return std::tanh((phase - 2.0) / 0.1) - std::tanh((phase - 5.0) / 0.1);
}

Simulation simulate(const Options& o) {
  check(o);
  Simulation simulation;
  Recording& recording = simulation.recording;
  Truth& truth = simulation.truth;
  const Motion motion(o.motion, o.motion_seed.value_or(o.seed));
  truth.device = o.device ? *o.device : draw_device(o.device_kind, o.device_seed.value_or(o.seed));
  truth.noise = {o.noise_factor * o.noise.acc, o.noise_factor * o.noise.gyr,
                 o.noise_factor * o.noise.mag};
  truth.gravity = o.gravity;
  truth.effects = o.effects;
  truth.t = sample_times(0.0, o.rate_hz, o.motion.duration_s);
  const double mag_rate_hz = o.mag_rate_hz > 0.0 ? o.mag_rate_hz : o.rate_hz;
  const std::vector<double> mag_t = sample_times(o.mag_first_s, mag_rate_hz, o.motion.duration_s);
  if (mag_t.empty()) throw std::invalid_argument("oracle: the magnetometer has no samples");

  const double clock = 1.0 + clock_scale(o.effects);
  std::vector<double> true_t = scaled(truth.t, clock);
  true_t.push_back(clock * (static_cast<double>(truth.t.size()) / o.rate_hz));
  follow(motion, true_t, truth);

  const ImuModel imu(o, truth.device, motion, true_t);
  const MagModel mag(o, truth.device, motion, scaled(mag_t, clock));
  recording.acc = series(truth.t, imu.acc(), Channel::kAcc, o.noise.acc, o.rate_hz, o);
  recording.gyr = series(truth.t, imu.gyr(), Channel::kGyr, o.noise.gyr, o.rate_hz, o);
  recording.mag = {series(mag_t, mag.readings(), Channel::kMag, o.noise.mag, mag_rate_hz, o)};
  recording.mag_names = {"mag"};
  recording.name = "oracle (" + to_string(o.motion.kind) + ", seed " + std::to_string(o.seed) + ")";
  truth.gyr_bias_drift = imu.gyr_bias_drift();
  if (!truth.gyr_bias_drift.empty()) truth.gyr_bias_drift.pop_back();
  add_columns(o, truth, true_t, recording);
  MotionTruth& known = recording.truth.emplace();
  known.t = truth.t;
  known.nRb = truth.nRb;
  known.position = truth.p;
  known.valid.assign(truth.t.size(), true);
  return simulation;
}

}  // namespace magimu::oracle
