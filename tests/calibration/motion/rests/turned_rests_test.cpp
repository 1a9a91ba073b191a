// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/rests/turned_rests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace magimu {
namespace {

constexpr double kLasts = 120.0;  // s
const Vector3 kGyrBias(-0.01, 0.006, 0.008);

struct Noise {
  double acc, gyr, mag;  // of a sample
};
constexpr Noise kSmall{0.015, 0.0015, 0.3};
constexpr Noise kLarge{0.3, 0.01, 3.0};

// A sensor that turns about an axis of its own by angle(t), rad, with noise.
Recording turning(const Vector3& axis, const std::function<double(double)>& angle,
                  const Noise& noise, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto white = [&](double sigma) {
    return Vector3(sigma * Vector3(normal(random), normal(random), normal(random)));
  };
  const Vector3 gravity = 9.81 * Vector3(0.1, -0.2, 0.97).normalized(), field(10.0, 20.0, -43.0);
  const Vector3 u = axis.normalized();
  constexpr double kImuRate = 52.0, kInstant = 1e-3;  // Hz, s
  Recording r;
  r.mag.emplace_back();
  r.mag_names = {"mag"};
  for (int k = 0; k < int(kLasts * kImuRate); ++k) {
    const double t = k / kImuRate;
    const double rate = (angle(t + kInstant) - angle(t - kInstant)) / (2.0 * kInstant);
    const Matrix3 to_body = Rot3::Exp(-angle(t) * u).matrix();
    r.acc.push_back(t, to_body * gravity + white(noise.acc));
    r.gyr.push_back(t, rate * u + kGyrBias + white(noise.gyr));
    if (k % 5 == 0) {
      r.mag.front().push_back(t, to_body * field + Vector3(-20.0, 5.0, 30.0) + white(noise.mag));
    }
  }
  return r;
}

double length_of(const std::vector<TimeSpan>& rests) {
  double out = 0.0;
  for (const TimeSpan& rest : rests) out += rest.length_s();
  return out;
}

double still(double) { return 0.0; }

std::function<double(double)> roll(double degrees, double period_s) {
  return [=](double t) { return degrees * M_PI / 180.0 * std::sin(2.0 * M_PI * t / period_s); };
}

TEST(TurnedRests, a_ships_slow_roll_is_no_rest) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    for (const Noise& noise : {kSmall, Noise{0.08, 0.008, 0.5}}) {
      const Recording r = turning(Vector3(1.0, 0.3, 0.1), roll(10.0, 8.0), noise, seed);
      EXPECT_LT(length_of(find_rests(r)), 0.1 * kLasts) << seed;
    }
  }
}

// Where it turns too little to show within some seconds its noise is still that of the samples.
TEST(TurnedRests, the_noise_at_rest_is_the_samples_where_a_sensor_rolls_slowly) {
  for (const double degrees : {0.1, 0.5, 2.0}) {
    for (const double period_s : {8.0, 20.0, 60.0}) {
      const Recording r = turning(Vector3(1.0, 0.3, 0.1), roll(degrees, period_s), kSmall, 4);
      const std::vector<TimeSpan> rests = find_rests(r);
      if (length_of(rests) < 2.0) continue;  // too few to tell a noise
      const NoiseDensities density = noise_at_rest(r, rests);
      EXPECT_NEAR(density.acc * std::sqrt(52.0) / kSmall.acc, 1.0, 0.35) << degrees << period_s;
    }
  }
}

TEST(TurnedRests, a_slow_turn_about_the_vertical_shows_in_the_magnetometer) {
  const Recording r = turning(Vector3(0.1, -0.2, 0.97), roll(10.0, 8.0), kSmall, 5);
  EXPECT_LT(length_of(find_rests(r)), 0.2 * kLasts);
}

TEST(TurnedRests, a_steady_turn_shows_in_gravity_though_the_gyroscope_calls_it_a_bias) {
  const Recording r = turning(
      Vector3(1.0, 0.3, 0.1), [](double t) { return 0.02 * t; }, kSmall, 6);
  EXPECT_LT(length_of(find_rests(r)), 0.1 * kLasts);
}

TEST(TurnedRests, a_rest_stays_whole_with_noise_of_any_size) {
  int whole = 0, all = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    for (const Noise& noise : {kSmall, kLarge}) {
      const Recording r = turning(Vector3(1.0, 0.0, 0.0), still, noise, seed);
      const std::vector<TimeSpan> rests = find_rests(r);
      whole += rests.size() == 1 && rests.front().length_s() > kLasts - 1.1 ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GE(whole, all - 2);  // one in a hundred may be cut
}

TEST(TurnedRests, coarse_converters_vibration_and_drifts_leave_a_rest_whole) {
  Recording r = turning(Vector3(1.0, 0.0, 0.0), still, kSmall, 7);
  Recording coarse = r, shaken = r, drifting = r;
  for (std::size_t k = 0; k < r.acc.size(); ++k) {
    const double t = r.acc.t[k];
    coarse.acc.v[k] = ((r.acc.v[k] / 0.15).array().round() * 0.15).matrix();
    coarse.gyr.v[k] = ((r.gyr.v[k] / 0.005).array().round() * 0.005).matrix();
    shaken.acc.v[k] += Vector3(0.5, 0.3, 1.0) * std::sin(2.0 * M_PI * 7.3 * t);
    shaken.gyr.v[k] += Vector3(0.02, 0.01, 0.01) * std::sin(2.0 * M_PI * 7.3 * t + 1.0);
    drifting.acc.v[k] += Vector3(5e-4, -3e-4, 8e-4) * t;
    drifting.gyr.v[k] += Vector3(1e-5, 2e-5, -1e-5) * t;
  }
  for (const Recording* each : {&coarse, &shaken, &drifting}) {
    const std::vector<TimeSpan> rests = find_rests(*each);
    ASSERT_EQ(rests.size(), 1U);
    EXPECT_GT(rests.front().length_s(), kLasts - 1.1);
  }
}

TEST(TurnedRests, noise_with_a_memory_leaves_a_rest_whole) {
  int whole = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Recording r = turning(Vector3(1.0, 0.0, 0.0), still, kSmall, seed);
    std::mt19937_64 random(seed + 100);
    std::normal_distribution<double> normal;
    Vector3 of_acc = Vector3::Zero(), of_gyr = Vector3::Zero();
    for (std::size_t k = 0; k < r.acc.size(); ++k) {
      for (Vector3* x : {&of_acc, &of_gyr}) {
        *x = 0.9 * *x + 0.44 * Vector3(normal(random), normal(random), normal(random));
      }
      r.acc.v[k] += 0.05 * of_acc;
      r.gyr.v[k] += 0.002 * of_gyr;
    }
    const std::vector<TimeSpan> rests = find_rests(r);
    whole += rests.size() == 1 && rests.front().length_s() > kLasts - 1.1 ? 1 : 0;
  }
  EXPECT_GE(whole, 16);
}

TEST(TurnedRests, a_magnet_that_comes_near_does_not_end_a_rest) {
  Recording r = turning(Vector3(1.0, 0.0, 0.0), still, kSmall, 8);
  VectorSeries& mag = r.mag.front();
  for (std::size_t k = 0; k < mag.size(); ++k) {
    mag.v[k] += 20.0 * std::exp(-std::pow((mag.t[k] - 60.0) / 5.0, 2)) * Vector3(1.0, 0.5, 0.0);
  }
  EXPECT_EQ(find_rests(r).size(), 1U);
}

// Put down on something soft, it sinks by a degree within a second: that second is cut off, not
// more.
TEST(TurnedRests, what_settles_at_the_beginning_is_cut_off) {
  const Recording r = turning(
      Vector3(1.0, 0.3, 0.1), [](double t) { return 0.02 * std::exp(-t / 0.7); }, kSmall, 9);
  const std::vector<TimeSpan> rests = find_rests(r);
  ASSERT_EQ(rests.size(), 1U);
  EXPECT_GT(rests.front().begin_s, 1.0);
  EXPECT_LT(rests.front().begin_s, 6.0);
  EXPECT_GT(rests.front().end_s, kLasts - 1.0);
}

}  // namespace
}  // namespace magimu
