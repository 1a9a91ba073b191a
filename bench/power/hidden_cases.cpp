// SPDX-License-Identifier: BSD-3-Clause
// What is drawn from a seed: hidden_cases.h.
#include "bench/power/hidden_cases.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace magimu {
namespace {

using oracle::MotionKind;

template <class T>
T pick(const std::vector<T>& from, double u) {
  return from[std::size_t(u * double(from.size()))];
}

bool one_of(const std::string& name, std::initializer_list<const char*> list) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

bool needs_place(const std::string& effect) {
  return one_of(effect, {"field_gradient", "stationary_source"});
}

// A device, its motion and its noise.
oracle::Options draw_options(std::uint64_t seed) {
  oracle::Options o;
  o.seed = seed;
  o.rate_hz = pick<double>({50.0, 62.5, 80.0, 100.0, 104.0, 125.0, 160.0, 200.0}, draw(seed, 1));
  if (draw(seed, 2) < 1.0 / 3.0) o.mag_rate_hz = o.rate_hz / 2.0;
  const bool board = draw(seed, 3) < 0.5;
  o.device_kind = board ? oracle::DeviceKind::kBoard : oracle::DeviceKind::kTableI;
  o.noise = draw(seed, 4) < 0.5 ? oracle::kRealisticDensities : oracle::kTableIDensities;
  o.motion.duration_s = std::round(90.0 + 90.0 * draw(seed, 5));
  o.motion.fastest_rad_s = 1.5 + 1.5 * draw(seed, 6);
  o.motion.displacement_m = 0.04 + 0.08 * draw(seed, 7);
  o.motion.band_hz[1] = 1.0 + 0.5 * draw(seed, 8);
  o.motion.kind = draw(seed, 9) < 0.4 ? MotionKind::kHandHeld : MotionKind::kRotation;
  return o;
}

// What a motion must have to show an effect, and the columns without which it cannot be told.
void make_visible(oracle::Options& o, const std::string& effect, std::uint64_t seed) {
  // A hand's motion follows the accelerometer: it absorbs them, or all but absurd sizes.
  if (one_of(effect, {"lever_arm", "acc_tapping", "acc_hysteresis"})) {
    o.motion.kind = MotionKind::kRotation;
  }
  if (needs_place(effect) || effect == "linear_acceleration") o.motion.kind = MotionKind::kHandHeld;
  if (needs_place(effect)) {
    o.record_pos = true;
    if (draw(seed, 20) < 0.5) o.motion.carry_m = 0.2;
  }
  if (one_of(effect, {"gyro_temperature", "acc_temperature", "mag_temperature"})) {
    o.record_temp = true;
  }
  if (effect == "mag_current") o.record_current = true;
  if (effect == "mains_interference") {
    // At 50 and 100 Hz it would stand still.
    o.rate_hz = pick<double>({62.5, 80.0, 104.0, 125.0, 160.0, 200.0}, draw(seed, 1));
    o.mag_rate_hz = 0.0;
  }
}

double field_of(const oracle::Options& o) {
  return o.device_kind == oracle::DeviceKind::kBoard ? 48.0 : 27.0;
}

// The largest reading of any axis of the magnetometer, uT: full scales are just below.
double largest_reading(oracle::Options o) {
  o.effects.clear();
  o.noise_factor = 0.0;
  double largest = 0.0;
  const Recording exact = oracle::simulate(o).recording;
  for (const Vector3& m : exact.mag.front().v) {
    largest = std::max(largest, m.cwiseAbs().maxCoeff());
  }
  return largest;
}

oracle::Effect draw_effect(const std::string& name, const oracle::Options& o, std::uint64_t seed) {
  oracle::EffectScale scale;
  scale.duration_s = o.motion.duration_s;
  scale.field_uT = name == "mag_saturation" ? largest_reading(o) : field_of(o);
  // Noise of the gyroscope, and in a hand that of the accelerometer, is what the trajectory
  // follows: no residual shows its samples.
  const bool moved = o.motion.kind == MotionKind::kHandHeld;
  const bool of_a_channel =
      one_of(name, {"noise_scale", "correlated_noise", "outliers", "sample_repetition"});
  if (of_a_channel && !moved && draw(seed, 21) < 0.4) scale.channel = oracle::Channel::kAcc;
  return oracle::random_effect(name, seed, scale);
}

bool alike(const std::string& a, const std::string& b) {
  static const std::vector<std::vector<std::string>> classes = {
      {"mag_time_offset", "mag_lag", "mag_eddy_current", "mag_axis_time_offset"},
      {"clock_scale", "gyro_scale_misalignment"},
      {"noise_scale", "correlated_noise", "outliers", "mag_quantization"},
      {"field_gradient", "stationary_source"},
      {"lever_arm", "field_gradient", "stationary_source", "linear_acceleration"}};
  for (const std::vector<std::string>& c : classes) {
    const auto in = [&](const std::string& x) {
      return std::find(c.begin(), c.end(), x) != c.end();
    };
    if (in(a) && in(b)) return true;
  }
  return a == b;
}

}  // namespace

double draw(std::uint64_t seed, int purpose) {
  std::uint64_t x = seed * 0x9E3779B97F4A7C15u + std::uint64_t(purpose) * 0xD1B54A32D192ED03u;
  for (int i = 0; i < 3; ++i) {
    x ^= x >> 31;
    x *= 0xBF58476D1CE4E5B9u;
  }
  return double(x >> 11) * 0x1p-53;
}

std::vector<std::string> hidden_effects() {
  std::vector<std::string> names = oracle::catalogue_effects();
  const std::vector<std::string>& later = oracle::later_effects();
  // A change of the accelerometer is named at usual sizes (tests/diagnosis/later_effects_test.cpp),
  // not yet in every setting that is drawn here: a moved hand takes up what it explains.
  std::ranges::copy_if(later, std::back_inserter(names),
                       [](const std::string& name) { return name != "acc_change"; });
  names.push_back("linear_acceleration");
  return names;
}

HiddenCase draw_case(const std::string& effect, std::uint64_t case_seed) {
  // Every effect has settings of its own for each seed.
  std::uint64_t seed = case_seed;
  for (const char letter : effect) seed = seed * 31 + std::uint64_t(letter);
  HiddenCase c;
  c.seed = case_seed;
  c.hidden = {effect};
  c.options = draw_options(seed);
  make_visible(c.options, effect, seed);
  // A scale of the noise is one against what was told.
  c.noise_given = effect == "noise_scale" || draw(seed, 10) < 0.5;
  if (effect != "linear_acceleration") c.options.effects = {draw_effect(effect, c.options, seed)};
  return c;
}

HiddenCase draw_pair(std::uint64_t seed) {
  const std::vector<std::string>& names = oracle::catalogue_effects();
  const std::string first = pick(names, draw(seed, 30));
  std::string second = first;
  for (int i = 31; alike(first, second); ++i) second = pick(names, draw(seed, i));
  HiddenCase c = draw_case(first, seed);
  make_visible(c.options, second, seed);
  c.noise_given = c.noise_given || second == "noise_scale";
  c.hidden = {first, second};
  c.options.effects = {draw_effect(first, c.options, seed), draw_effect(second, c.options, seed)};
  return c;
}

std::string to_string(NoiseKind kind) {
  return kind == NoiseKind::kWhite      ? "white"
         : kind == NoiseKind::kColoured ? "coloured"
                                        : "heavy-tailed";
}

HiddenCase draw_none(NoiseKind noise, std::uint64_t seed) {
  HiddenCase c;
  c.seed = seed;
  c.options = draw_options(seed);
  c.noise_given = draw(seed, 10) < 0.5;
  if (noise == NoiseKind::kWhite) return c;
  using enum oracle::Channel;
  const double correlated_s = 0.15 + 0.15 * draw(seed, 11);
  const double eps = 0.005 + 0.015 * draw(seed, 12), size = 5.0 + 5.0 * draw(seed, 13);
  for (const oracle::Channel channel : {kAcc, kGyr, kMag}) {
    const bool slow = channel == kMag && c.options.mag_rate_hz > 0.0;
    const double rate = slow ? c.options.mag_rate_hz : c.options.rate_hz;
    c.options.effects.push_back(noise == NoiseKind::kColoured
                                    ? oracle::make_effect("correlated_noise",
                                                          {std::exp(-1.0 / (rate * correlated_s))},
                                                          channel)
                                    : oracle::make_effect("outliers", {eps, size}, channel));
  }
  return c;
}

DiagnosisOptions diagnosis_options(const HiddenCase& c) {
  DiagnosisOptions options;
  options.gravity = c.options.gravity;
  options.calibrate_before = false;  // causes are asked for
  if (c.noise_given) {
    options.noise = NoiseDensities{c.options.noise.acc, c.options.noise.gyr, c.options.noise.mag};
  }
  return options;
}

oracle::Options second_recording(const HiddenCase& c) {
  oracle::Options o = c.options;
  o.device_seed = c.options.device_seed.value_or(c.options.seed);
  o.seed = c.options.seed + 1000003;
  o.motion_seed = o.seed;
  return o;
}

}  // namespace magimu
