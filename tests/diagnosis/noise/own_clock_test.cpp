// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/own_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace magimu {
namespace {

constexpr double kReadHz = 100.0, kMagSigma = 0.5, kClockLevel = 1e-5;

// A field of 50 uT in a sensor that turns to and fro; age_s of each sample as a function of time.
template <typename Age>
SampleResiduals samples_of_age(unsigned seed, const Age& age_s, double seconds = 120.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  SampleResiduals out{.channel = Sensor::kMag};
  const int n = int(seconds * kReadHz);
  double mean = 0.0;
  for (int k = 0; k < n; ++k) mean += age_s(k / kReadHz) / n;
  for (int k = 0; k < n; ++k) {
    const double t = k / kReadHz;
    const Vector3 change = 50.0 * Vector3(std::sin(1.3 * t), std::cos(0.9 * t), 0.3);
    out.t.push_back(t);
    out.change.push_back(change);
    out.across.push_back(change.cross(Vector3::UnitZ()));
    const Vector3 noise = kMagSigma * Vector3(normal(random), normal(random), normal(random));
    out.residual.push_back(noise - (age_s(t) - mean) * change);
    out.reading.push_back(Vector3::Zero());
  }
  return out;
}

double sawtooth_age(double t, double period_s) {
  const double turns = t / period_s + 0.37;
  return period_s * (turns - std::floor(turns));
}

TEST(SlowClock, shows_in_the_samples_where_its_pattern_is_fast) {
  for (const double period_ms : {9.6, 8.3, 10.4, 12.0, 4.77}) {
    const SampleResiduals mag =
        samples_of_age(5201, [&](double t) { return sawtooth_age(t, 1e-3 * period_ms); });
    const auto clock = find_own_clock(mag, kClockLevel);
    ASSERT_TRUE(clock) << period_ms;
    EXPECT_TRUE(clock->held) << period_ms;
    EXPECT_NEAR(1e3 * clock->period_s, period_ms, std::max(1e-4, 4e3 * clock->period_sigma_s));
  }
}

// What attitudes take of ages that repeat themselves slowly: their mean over two seconds.
TEST(SlowClock, is_possible_however_slowly_it_folds) {
  for (const double period_ms : {9.98, 9.96, 9.9, 9.85, 10.02, 10.05, 10.1, 4.99}) {
    const auto age = [&](double t) { return sawtooth_age(t, 1e-3 * period_ms); };
    const SampleResiduals whole = samples_of_age(5202, age);
    const SampleResiduals taken = samples_of_age(5202, [&](double t) {
      double mean = 0.0;
      for (int k = -100; k < 100; ++k) mean += age(t + k / kReadHz) / 200.0;
      return age(t) - mean;
    });
    for (const SampleResiduals& mag : {whole, taken}) {
      const std::vector<OwnClock> clocks = find_own_clocks(mag, kClockLevel);
      EXPECT_TRUE(std::ranges::any_of(clocks, [&](const OwnClock& c) {
        return std::abs(1e3 * c.period_s - period_ms) < std::max(2e-4, 4e3 * c.period_sigma_s);
      })) << period_ms;
    }
  }
}

TEST(SlowClock, is_told_anew_by_the_residuals_of_a_model_that_has_it) {
  const OwnClock nearly{.period_s = 9.96001e-3, .share = 0.366};
  SampleResiduals mag = samples_of_age(5203, [](double t) { return sawtooth_age(t, 9.96e-3); });
  for (std::size_t k = 0; k < mag.t.size(); ++k) {
    const double turns = mag.t[k] / nearly.period_s + nearly.share;
    mag.residual[k] += nearly.period_s * (turns - std::floor(turns)) * mag.change[k];
  }
  const OwnClock told = told_anew(nearly, mag);
  EXPECT_NEAR(told.period_s, 9.96e-3, 2e-8);
  EXPECT_NEAR(told.share, 0.37, 4.0 * told.share_sigma);
}

TEST(SlowClock, is_neither_white_noise_nor_told_by_samples_that_repeat_themselves_otherwise) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const SampleResiduals white = samples_of_age(
        seed, [](double) { return 0.0; }, 60.0);
    EXPECT_TRUE(find_own_clocks(white, kClockLevel).empty());
  }
  for (const double f_hz : {0.1, 0.4}) {
    const double turn = 2.0 * std::numbers::pi * f_hz;
    const auto sine = [&](double t) { return 0.004 * std::sin(turn * t); };
    EXPECT_FALSE(find_own_clock(samples_of_age(21, sine), kClockLevel)) << f_hz;
  }
}

}  // namespace
}  // namespace magimu
