// SPDX-License-Identifier: BSD-3-Clause
// Samples of other times than they say against noise of every kind.
#include "diagnosis/noise/timing_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace magimu {
namespace {

constexpr double kFieldRate = 50.0, kFieldTurned = 120.0;

double one_normal(std::mt19937_64& random) { return std::normal_distribution<double>()(random); }

// A field of 50 that is turned faster and slower about a wandering axis.
SampleResiduals field_being_turned() {
  SampleResiduals out;
  Rot3 nRb;
  for (double t = 0.0; t < kFieldTurned; t += 1.0 / kFieldRate) {
    const Vector3 axis(std::sin(0.31 * t), std::cos(0.23 * t), std::sin(0.17 * t + 1.0));
    const Vector3 omega = (1.0 + std::sin(0.8 * t)) * axis, b = nRb.unrotate(Vector3(20, 0, 45));
    out.t.push_back(t);
    out.reading.push_back(b);
    out.change.push_back(b.cross(omega));
    out.across.push_back(b.normalized().cross(out.change.back()));
    nRb = nRb * Rot3::Exp(omega / kFieldRate);
  }
  return out;
}

using NoiseOf = std::function<Vector3(std::mt19937_64&, double rate)>;

TimingNoise seen_with(const NoiseOf& noise, double jitter_s, std::uint64_t seed,
                      double coloured = 0.0) {
  static const SampleResiduals field = field_being_turned();
  SampleResiduals s = field;
  std::mt19937_64 random(seed);
  Vector3 slow = Vector3::Zero();
  for (std::size_t k = 0; k < s.t.size(); ++k) {
    const double rate = s.change[k].norm() / 50.0;
    slow = coloured * slow + noise(random, rate);
    s.residual.push_back(slow + jitter_s * one_normal(random) * s.change[k]);
  }
  return timing_noise(s);
}

Vector3 white_vector(std::mt19937_64& random) {
  return {one_normal(random), one_normal(random), one_normal(random)};
}

int alarms(const NoiseOf& noise, double coloured = 0.0) {
  int below = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    below += seen_with(noise, 0.0, seed, coloured).log10_p < -2.0;
  }
  return below;
}

// 2 expected; more than 7 has a probability of 0.1 %.
TEST(TimingNoise, holds_its_level_on_white_coloured_and_heavy_tailed_noise) {
  EXPECT_LE(alarms([](auto& random, double) { return white_vector(random); }), 7);
  EXPECT_LE(alarms([](auto& random, double) { return white_vector(random); }, 0.95), 7);
  EXPECT_LE(alarms([](auto& random, double) {
              return Vector3(white_vector(random) * (random() % 100 == 0 ? 20.0 : 1.0));
            }),
            7);
}

TEST(TimingNoise, is_not_noise_that_grows_with_the_rate_or_differs_between_axes) {
  EXPECT_LE(alarms([](auto& random, double rate) {
              return Vector3((1.0 + rate) * white_vector(random));
            }),
            7);
  EXPECT_LE(alarms([](auto& random, double) {
              return Vector3(white_vector(random).cwiseProduct(Vector3(1.0, 2.0, 5.0)));
            }),
            7);
}

// The trajectory's errors turn the field: nothing is left along it, as much in every direction
// across.
TEST(TimingNoise, is_no_error_of_the_attitude) {
  static const SampleResiduals field = field_being_turned();
  int below = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SampleResiduals s = field;
    std::mt19937_64 random(seed);
    for (std::size_t k = 0; k < s.t.size(); ++k) {
      s.residual.push_back(white_vector(random) + 0.02 * s.reading[k].cross(white_vector(random)));
    }
    below += timing_noise(s).log10_p < -2.0;
  }
  EXPECT_LE(below, 7);
}

TEST(TimingNoise, is_found_with_its_size) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    // 0.5 at a rate of 1 rad/s, half the noise.
    const TimingNoise seen =
        seen_with([](auto& random, double) { return white_vector(random); }, 0.01, seed);
    EXPECT_LT(seen.log10_p, -6.0);
    EXPECT_NEAR(seen.jitter_s, 0.0095, 0.0012);
    EXPECT_EQ(seen.period_s, 0.0);
  }
}

// Read every 20 ms, measured every 28.571: as old again after 0.2 s.
TEST(TimingNoise, tells_the_pattern_of_a_sensor_with_a_slower_clock) {
  SampleResiduals s = field_being_turned();
  std::mt19937_64 random(1);
  for (std::size_t k = 0; k < s.t.size(); ++k) {
    const double age = double(7 * k % 10) * 0.02 / 7.0;
    s.residual.push_back(white_vector(random) - age * s.change[k]);
  }
  const TimingNoise seen = timing_noise(s);
  EXPECT_LT(seen.log10_p, -6.0);
  EXPECT_NEAR(seen.period_s, 0.2, 1e-9);
}

TEST(TimingNoise, needs_to_know_how_the_reading_changes) {
  SampleResiduals s = field_being_turned();
  s.residual = s.change;
  s.change.clear();
  EXPECT_EQ(timing_noise(s).log10_p, 0.0);
}

}  // namespace
}  // namespace magimu
