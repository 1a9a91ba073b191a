// SPDX-License-Identifier: BSD-3-Clause
// Noise-like causes on the oracle's recordings: hidden, they are found with their parameters; where
// something else is hidden, none is.
#include "diagnosis/noise/noise_tests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "diagnosis/noise/high_pass.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

constexpr double kNoiseLevel = 1e-4;
constexpr oracle::Densities kNoise{2e-3, 1.5e-4, 0.05};  // at 100 Hz: 0.02 m/s^2, 0.0015, 0.5 uT

oracle::Options options(std::uint64_t seed, std::vector<oracle::Effect> effects) {
  oracle::Options o;
  o.seed = seed;
  o.motion.duration_s = 100.0;
  o.noise = kNoise;
  o.device_kind = oracle::DeviceKind::kBoard;
  o.effects = std::move(effects);
  return o;
}

// A little of something slow: what a fit leaves, or what nobody has thought of. In sigmas.
Vector3 slow_remainder(double t) {
  return Vector3(std::sin(4.1 * t), std::cos(2.3 * t + 1.0), std::sin(0.2 * t) + std::sin(5.5 * t));
}

SampleResiduals residuals(const VectorSeries& series, Sensor channel, double density,
                          const std::function<Vector3(std::size_t)>& model, double slow) {
  SampleResiduals r;
  r.channel = channel;
  r.t = series.t;
  r.reading = series.v;
  r.sigma = density * std::sqrt(series.rate_hz());
  r.sigma_given = true;
  for (std::size_t k = 0; k < series.size(); ++k) {
    r.residual.push_back(series.v[k] - model(k) + slow * r.sigma * slow_remainder(series.t[k]));
  }
  return r;
}

// Of all samples at the device's truth.
SampleResiduals mag_residuals(const oracle::Simulation& s, double slow = 0.0) {
  const oracle::Device& device = s.truth.device;
  SampleResiduals r = residuals(
      s.recording.mag[0], Sensor::kMag, kNoise.mag,
      [&](std::size_t k) -> Vector3 {
        return device.distortion * s.truth.nRb[k].unrotate(device.unit_field()) + device.mag_bias;
      },
      slow);
  const double strength = std::cbrt(device.distortion.determinant());
  for (std::size_t k = 0; k < r.t.size(); ++k) {
    r.to_n.push_back(s.truth.nRb[k].matrix() * (strength * device.distortion.inverse()));
  }
  return r;
}

SampleResiduals acc_residuals(const oracle::Simulation& s, double slow = 0.0) {
  return residuals(
      s.recording.acc, Sensor::kAcc, kNoise.acc,
      [&](std::size_t k) -> Vector3 {
        return s.truth.device.acc_bias + s.truth.nRb[k].unrotate(Vector3(0, 0, s.truth.gravity));
      },
      slow);
}

// What the trajectory leaves of a sensor that it follows.
SampleResiduals followed(const VectorSeries& series, Sensor channel, double density) {
  SampleResiduals r;
  r.channel = channel;
  r.t = series.t;
  r.reading = series.v;
  r.residual = high_passed(series);
  r.sigma = density * std::sqrt(series.rate_hz());
  r.sigma_given = true;
  r.high_passed = true;
  return r;
}

std::vector<SampleResiduals> all_channels(const oracle::Simulation& s) {
  return {followed(s.recording.acc, Sensor::kAcc, kNoise.acc),
          followed(s.recording.gyr, Sensor::kGyr, kNoise.gyr), mag_residuals(s)};
}

std::vector<std::string> names(const std::vector<NoiseTest>& tests) {
  std::vector<std::string> result;
  for (const NoiseTest& test : tests) result.push_back(to_string(test.channel) + " " + test.effect);
  return result;
}

void expect_parameter(const NoiseTest& test, std::size_t i, double truth) {
  const FoundParameter& p = test.parameters.at(i);
  EXPECT_LT(std::abs(p.value - truth), 4.0 * p.sigma + 1e-9 * std::abs(truth))
      << p.name << " = " << p.value << " +- " << p.sigma << ", truth " << truth << ": "
      << test.sentence;
  EXPECT_LT(p.sigma, 0.3 * std::abs(truth)) << p.name;
}

// Found alone, with parameters within four sigma and a gain on the other half.
void expect_found(const SampleResiduals& r, const std::string& effect,
                  const std::vector<double>& truth) {
  const std::vector<NoiseTest> found = explain_noise({r}, kNoiseLevel);
  ASSERT_THAT(names(found), testing::ElementsAre(to_string(r.channel) + " " + effect))
      << found.back().sentence;
  ASSERT_EQ(found[0].parameters.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) expect_parameter(found[0], i, truth[i]);
  EXPECT_LT(found[0].nll_after, found[0].nll_before - 5.0);
  EXPECT_GT(found[0].sentence.size(), 30u);
}

oracle::Effect effect(const std::string& name, const std::vector<double>& parameters,
                      oracle::Channel channel = oracle::Channel::kMag) {
  return oracle::make_effect(name, parameters, channel);
}

TEST(ExplainNoise, names_nothing_where_the_noise_is_as_given) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    EXPECT_THAT(
        names(explain_noise(all_channels(oracle::simulate(options(seed, {}))), kNoiseLevel)),
        testing::IsEmpty());
  }
}

TEST(ExplainNoise, leaves_slow_remainders_to_others) {
  const oracle::Simulation s = oracle::simulate(options(6, {}));
  for (const double slow : {0.1, 0.3, 1.0, 10.0}) {
    EXPECT_THAT(names(explain_noise({mag_residuals(s, slow), acc_residuals(s, slow)}, kNoiseLevel)),
                testing::IsEmpty())
        << slow;
  }
}

TEST(ExplainNoise, leaves_errors_of_the_reading_to_others) {
  for (const std::string& name : oracle::catalogue_effects()) {
    if (name == "mains_interference" || name == "noise_scale" || name == "correlated_noise" ||
        name == "outliers" || name == "mag_quantization" || name == "mag_saturation") {
      continue;
    }
    const oracle::Simulation s =
        oracle::simulate(options(7, {oracle::random_effect(name, 7, {.field_uT = 48.0})}));
    EXPECT_THAT(names(explain_noise(all_channels(s), kNoiseLevel)), testing::IsEmpty()) << name;
  }
}

TEST(ExplainNoise, finds_noise_of_another_size) {
  for (const double scale : {0.7, 1.1, 2.5}) {
    const oracle::Simulation s =
        oracle::simulate(options(8, {effect("noise_scale", {scale}),
                                     effect("noise_scale", {scale}, oracle::Channel::kGyr)}));
    expect_found(mag_residuals(s, 0.3), "noise_scale", {scale});
    expect_found(followed(s.recording.gyr, Sensor::kGyr, kNoise.gyr), "noise_scale", {scale});
  }
}

TEST(ExplainNoise, says_nothing_about_the_size_where_no_density_is_given) {
  SampleResiduals r = mag_residuals(oracle::simulate(options(9, {effect("noise_scale", {2.0})})));
  r.sigma_given = false;
  EXPECT_THAT(names(explain_noise({r}, kNoiseLevel)), testing::IsEmpty());
}

TEST(ExplainNoise, finds_correlated_noise) {
  for (const double rho : {0.3, 0.6, 0.75, 0.9}) {
    const oracle::Simulation s = oracle::simulate(options(10, {effect("correlated_noise", {rho})}));
    expect_found(mag_residuals(s), "correlated_noise", {rho});
    expect_found(mag_residuals(s, 0.3), "correlated_noise", {rho});
  }
}

TEST(ExplainNoise, finds_correlated_noise_where_the_trajectory_follows) {
  for (const double rho : {0.3, 0.5, 0.6}) {
    const oracle::Simulation s =
        oracle::simulate(options(11, {effect("correlated_noise", {rho}, oracle::Channel::kGyr)}));
    expect_found(followed(s.recording.gyr, Sensor::kGyr, kNoise.gyr), "correlated_noise", {rho});
  }
}

TEST(ExplainNoise, says_that_no_filter_makes_neighbours_opposite) {
  SampleResiduals r = mag_residuals(oracle::simulate(options(10, {})));
  for (std::size_t k = r.residual.size() - 1; k > 0; --k) r.residual[k] -= 0.5 * r.residual[k - 1];
  EXPECT_THAT(names(explain_noise({r}, kNoiseLevel)),
              testing::Not(testing::Contains(testing::HasSubstr("correlated_noise"))));
  bool said = false;
  for (const NoiseTest& test : test_noise({r})) {
    said |=
        test.effect == "correlated_noise" && test.untested.find("opposite") != std::string::npos;
  }
  EXPECT_TRUE(said);
}

TEST(ExplainNoise, finds_outliers) {
  for (const auto& [eps, K] :
       {std::pair(0.005, 10.0), std::pair(0.02, 30.0), std::pair(0.05, 5.0)}) {
    const oracle::Simulation s = oracle::simulate(options(
        12, {effect("outliers", {eps, K}), effect("outliers", {eps, K}, oracle::Channel::kAcc)}));
    expect_found(mag_residuals(s), "outliers", {eps, K});
    expect_found(mag_residuals(s, 0.3), "outliers", {eps, K});
    expect_found(followed(s.recording.acc, Sensor::kAcc, kNoise.acc), "outliers", {eps, K});
  }
}

// A turntable that speeds up and slows down evenly, read 50 times a second: where it begins and
// ends to, the rate bends, which stands out of the noise as far as outliers do.
VectorSeries starts_and_stops(std::uint64_t seed) {
  constexpr double kRate = 50.0, kPeriod = 4.0, kTurns = 2.0, kSteep = 0.5;
  const Vector3 axis = Vector3(1.0, -0.7, 0.4);
  VectorSeries gyr = oracle::simulate(options(seed, {})).recording.gyr;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, kNoise.gyr * std::sqrt(kRate));
  double begin = 0.0;
  for (std::size_t k = 0; k < gyr.size(); ++k) {
    gyr.t[k] = double(k) / kRate;
    if (gyr.t[k] > begin + kPeriod) begin += kPeriod + 1e-3 * double(random() % 100);
    const double in = gyr.t[k] - begin;
    const double up = std::clamp(in, 0.0, 1.0) - std::clamp(in - kTurns, 0.0, 1.0);
    gyr.v[k] = kSteep * up * axis + Vector3(noise(random), noise(random), noise(random));
  }
  return gyr;
}

TEST(ExplainNoise, takes_no_start_or_stop_of_the_motion_for_outliers) {
  for (const std::uint64_t seed : {51u, 52u, 53u}) {
    const VectorSeries gyr = starts_and_stops(seed);
    EXPECT_THAT(names(explain_noise({followed(gyr, Sensor::kGyr, kNoise.gyr)}, kNoiseLevel)),
                testing::Not(testing::Contains("gyr outliers")));
  }
}

TEST(ExplainNoise, finds_outliers_among_starts_and_stops) {
  VectorSeries gyr = starts_and_stops(54);
  std::mt19937_64 random(54);
  std::normal_distribution<double> far(0.0, 8.0 * kNoise.gyr * std::sqrt(gyr.rate_hz()));
  for (Vector3& w : gyr.v) {
    if (random() % 100 == 0) w += Vector3(far(random), far(random), far(random));
  }
  EXPECT_THAT(names(explain_noise({followed(gyr, Sensor::kGyr, kNoise.gyr)}, kNoiseLevel)),
              testing::Contains("gyr outliers"));
}

// As where a sensor hangs for a while and bends the fit: other sensors' samples scatter there.
TEST(ExplainNoise, names_no_outliers_that_come_in_a_part_of_the_recording_alone) {
  for (const std::uint64_t seed : {64u, 65u, 66u}) {
    SampleResiduals r = mag_residuals(oracle::simulate(options(seed, {})));
    std::mt19937_64 random(seed);
    std::bernoulli_distribution more(0.15);
    std::normal_distribution<double> error(0.0, 3.0 * r.sigma);
    for (std::size_t k = 0; k < r.t.size(); ++k) {
      if (r.t[k] < 40.0 || r.t[k] > 65.0 || !more(random)) continue;
      r.residual[k] += Vector3(error(random), error(random), error(random));
    }
    for (const NoiseTest& t : explain_noise({r}, kNoiseLevel)) EXPECT_NE(t.effect, "outliers");
  }
}

// Of one in ten thousand nobody knows how often they come.
TEST(ExplainNoise, names_no_outliers_for_a_sample_or_two) {
  const oracle::Simulation s = oracle::simulate(options(14, {}));
  for (const bool high_passed : {false, true}) {
    SampleResiduals r =
        high_passed ? followed(s.recording.acc, Sensor::kAcc, kNoise.acc) : mag_residuals(s);
    r.residual[1500] += 12.0 * r.sigma * Vector3(1.0, -0.5, 0.5);
    EXPECT_THAT(explain_noise({r}, kNoiseLevel), testing::IsEmpty());
    r.residual[3500] += 12.0 * r.sigma * Vector3(-0.5, 1.0, 0.5);
    EXPECT_THAT(explain_noise({r}, kNoiseLevel), testing::IsEmpty());
  }
}

TEST(ExplainNoise, finds_the_steps_of_the_converter) {
  for (const double q : {0.3, 1.0 / 3.0, 1.0, 3.0}) {
    const SampleResiduals r =
        mag_residuals(oracle::simulate(options(13, {effect("mag_quantization", {q})})));
    const std::vector<NoiseTest> found = explain_noise({r}, kNoiseLevel);
    ASSERT_THAT(names(found), testing::ElementsAre("mag mag_quantization")) << q;
    expect_parameter(found[0], 0, q);
    EXPECT_LT(found[0].nll_after, found[0].nll_before);
  }
}

TEST(ExplainNoise, finds_steps_in_a_file_that_has_few_decimals) {
  SampleResiduals r =
      mag_residuals(oracle::simulate(options(14, {effect("mag_quantization", {1.0 / 3.0})})));
  for (std::size_t k = 0; k < r.t.size(); ++k) {
    const Vector3 written = 1e-3 * (1e3 * r.reading[k]).array().round();
    r.residual[k] += written - r.reading[k];
    r.reading[k] = written;
  }
  const std::vector<NoiseTest> found = explain_noise({r}, kNoiseLevel);
  ASSERT_THAT(names(found), testing::ElementsAre("mag mag_quantization"));
  expect_parameter(found[0], 0, 1.0 / 3.0);
}

TEST(ExplainNoise, passes_over_steps_that_are_far_below_the_noise) {
  for (const double q : {0.001, 0.01, 0.1}) {
    const SampleResiduals r =
        mag_residuals(oracle::simulate(options(15, {effect("mag_quantization", {q})})));
    EXPECT_THAT(names(explain_noise({r}, kNoiseLevel)), testing::IsEmpty()) << q;
  }
}

TEST(ExplainNoise, finds_the_limit_of_the_converter) {
  for (const double M : {40.0, 45.0}) {
    const oracle::Simulation s = oracle::simulate(options(16, {effect("mag_saturation", {M})}));
    expect_found(mag_residuals(s), "mag_saturation", {M});
    const oracle::Simulation both = oracle::simulate(
        options(16, {effect("mag_saturation", {M}), effect("mag_quantization", {0.25})}));
    EXPECT_THAT(names(explain_noise({mag_residuals(both)}, kNoiseLevel)),
                testing::Contains("mag mag_saturation"));
  }
}

TEST(ExplainNoise, finds_mains) {
  for (const double f : {13.7, 29.1, 44.2}) {
    const std::vector<double> truth = {0.3, -0.2, 0.25, -0.35, 0.3, 0.2, f};
    const SampleResiduals r =
        mag_residuals(oracle::simulate(options(17, {effect("mains_interference", truth)})), 0.3);
    expect_found(r, "mains_interference", truth);
  }
}

// Fixed in the room, not to the sensor, which turns meanwhile: in its frame no line stands there.
TEST(ExplainNoise, finds_mains_of_the_room_in_the_rooms_frame) {
  for (const double f : {13.7, 29.1, 44.2}) {
    const oracle::Simulation s = oracle::simulate(options(21, {}));
    SampleResiduals r = mag_residuals(s, 0.3);
    const Vector3 a(0.3, -0.2, 0.25), d(-0.35, 0.3, 0.2);
    for (std::size_t k = 0; k < r.t.size(); ++k) {
      const double phase = 2.0 * M_PI * f * r.t[k];
      const Vector3 more = r.to_n[k].inverse() * (a * std::cos(phase) + d * std::sin(phase));
      r.reading[k] += more;
      r.residual[k] += more;
    }
    expect_found(r, "mains_interference", {a.x(), a.y(), a.z(), d.x(), d.y(), d.z(), f});
    const std::vector<NoiseTest> found = explain_noise({r}, kNoiseLevel);
    EXPECT_EQ(found.front().parameters.front().name, "a_n_x");
    EXPECT_THAT(found.front().sentence, testing::HasSubstr("of the room"));
  }
}

TEST(ExplainNoise, finds_mains_next_to_half_the_sampling_rate) {
  const std::vector<double> truth = {3.0, -2.0, 2.5, -3.5, 3.0, 2.0, 50.04};
  const SampleResiduals r =
      mag_residuals(oracle::simulate(options(18, {effect("mains_interference", truth)})));
  const std::vector<NoiseTest> found = explain_noise({r}, kNoiseLevel);
  ASSERT_THAT(names(found), testing::ElementsAre("mag mains_interference"));
  const double f = found[0].parameters[6].value;  // 100 Hz - 50.04 Hz, mirrored: the sine changes
  expect_parameter(found[0], 6, f < 50.0 ? 49.96 : 50.04);
  for (std::size_t i = 0; i < 6; ++i) {
    expect_parameter(found[0], i, (i >= 3 && f < 50.0 ? -1.0 : 1.0) * truth[i]);
  }
  EXPECT_THAT(found[0].sentence, testing::HasSubstr("50 Hz"));
}

// A sensor that is waved, and what a model lacks of it, which has the motion's harmonics.
SampleResiduals waved(SampleResiduals r) {
  constexpr double kWaves = 1.855;  // Hz
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 0.1);  // uT/s, by the gyroscope's
  for (std::size_t k = 0; k < r.t.size(); ++k) {
    const double phase = 2.0 * std::numbers::pi * kWaves * r.t[k];
    r.change.push_back(Vector3(noise(random), noise(random), noise(random)) +
                       Vector3(40.0, -25.0, 10.0) * std::cos(phase) +
                       Vector3(2.0, 3.0, -1.0) * std::sin(4.0 * phase));
    r.residual[k] += Vector3(0.3, -0.2, 0.1) * std::cos(4.0 * phase);
  }
  return r;
}

TEST(ExplainNoise, takes_no_harmonic_of_the_motion_for_mains) {
  const SampleResiduals r = waved(mag_residuals(oracle::simulate(options(61, {}))));
  EXPECT_THAT(names(explain_noise({r}, kNoiseLevel)), testing::IsEmpty());
  for (const NoiseTest& t : test_noise({r})) {
    if (t.effect != "mains_interference") continue;
    EXPECT_THAT(t.untested, testing::HasSubstr("follows the motion"));
  }
}

TEST(ExplainNoise, finds_mains_beside_a_harmonic_of_the_motion) {
  const std::vector<double> truth{0.2, -0.1, 0.05, 0.05, 0.1, 0.1, 31.3};
  const SampleResiduals r =
      waved(mag_residuals(oracle::simulate(options(62, {effect("mains_interference", truth)}))));
  const std::vector<NoiseTest> found = explain_noise({r}, kNoiseLevel);
  ASSERT_THAT(names(found), testing::ElementsAre("mag mains_interference"));
  EXPECT_NEAR(found[0].parameters[6].value, 31.3, 4.0 * found[0].parameters[6].sigma);
}

TEST(ExplainNoise, names_no_outliers_that_are_smaller_than_the_noise) {
  SampleResiduals r = mag_residuals(oracle::simulate(options(63, {})));
  std::mt19937_64 random(7);
  std::bernoulli_distribution more(0.2);
  std::normal_distribution<double> error(0.0, 0.9 * r.sigma);
  for (Vector3& e : r.residual) {
    if (more(random)) e += Vector3(error(random), error(random), error(random));
  }
  for (const NoiseTest& t : explain_noise({r}, kNoiseLevel)) EXPECT_NE(t.effect, "outliers");
}

TEST(ExplainNoise, tells_causes_apart_that_come_together) {
  const oracle::Simulation s = oracle::simulate(
      options(19, {effect("outliers", {0.01, 15.0}), effect("correlated_noise", {0.7}),
                   effect("noise_scale", {1.5}),
                   effect("mains_interference", {0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 31.3})}));
  const std::vector<NoiseTest> found = explain_noise({mag_residuals(s)}, kNoiseLevel);
  ASSERT_THAT(names(found), testing::ElementsAre("mag mains_interference", "mag outliers",
                                                 "mag correlated_noise", "mag noise_scale"));
  EXPECT_NEAR(found[2].parameters[0].value, 0.7, 0.04);
  EXPECT_NEAR(found[3].parameters[0].value, 1.5, 0.1);
}

TEST(TestNoise, says_why_it_could_not_test) {
  SampleResiduals r = mag_residuals(oracle::simulate(options(20, {})));
  r.t.resize(100);
  r.reading.resize(100);
  r.residual.resize(100);
  for (const NoiseTest& test : test_noise({r})) {
    EXPECT_EQ(test.p_value, 1.0);
    EXPECT_FALSE(test.untested.empty()) << test.effect;
  }
}

}  // namespace
}  // namespace magimu
