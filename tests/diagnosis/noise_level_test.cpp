// SPDX-License-Identifier: BSD-3-Clause
// How often the noise tests alarm on hundreds of cheap series in which there is nothing, or
// something else; and how small a cause they find.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

#include "diagnosis/noise/high_pass.h"
#include "diagnosis/noise/noise_tests.h"
#include "factors/effects/noise_effects.h"

namespace magimu {
namespace {

constexpr double kSigma = 0.5, kRate = 100.0;

// Noise of this shape about a smooth reading.
SampleResiduals series(std::size_t n, const NoiseShape& shape, std::uint64_t seed) {
  SampleResiduals r;
  r.sigma = kSigma;
  r.sigma_given = true;
  r.residual.assign(n, Vector3::Zero());
  add_noise(r.residual, kSigma, shape, seed);
  for (std::size_t k = 0; k < n; ++k) {
    const double t = double(k) / kRate, phase = 0.1 * double(seed);
    const Vector3 model(std::sin(0.7 * t + phase), std::cos(0.4 * t), std::sin(0.3 * t));
    r.t.push_back(t);
    r.reading.push_back(40.0 * model + r.residual[k]);
  }
  return r;
}

SampleResiduals followed(SampleResiduals r) {
  r.channel = Sensor::kAcc;
  r.high_passed = true;
  r.residual = high_passed(r.residual);
  return r;
}

// Student's t with four degrees of freedom, of the same variance: Gaussian over the root of a
// chi-square, itself from Gaussians.
SampleResiduals heavy_tailed(std::size_t n, std::uint64_t seed) {
  SampleResiduals r = series(n, {}, seed);
  std::vector<Vector3> a(n, Vector3::Zero()), b = a;
  add_noise(a, 1.0, {}, seed + 100000);
  add_noise(b, 1.0, {}, seed + 200000);
  for (std::size_t k = 0; k < n; ++k) {
    const double chi_square = a[k].squaredNorm() + b[k].x() * b[k].x();
    const Vector3 wild = std::sqrt(2.0 / chi_square) * r.residual[k];
    r.reading[k] += wild - r.residual[k];
    r.residual[k] = wild;
  }
  return r;
}

using Shares = std::map<std::string, std::array<double, 2>>;  // of alarms at 5 % and at 1 %

Shares alarms(int replicates, const std::function<SampleResiduals(std::uint64_t)>& make) {
  Shares shares;
  for (int i = 0; i < replicates; ++i) {
    for (const NoiseTest& test : test_noise({make(std::uint64_t(i) + 1)})) {
      shares[test.effect][0] += test.p_value < 0.05 ? 1.0 / replicates : 0.0;
      shares[test.effect][1] += test.p_value < 0.01 ? 1.0 / replicates : 0.0;
    }
  }
  return shares;
}

// Three standard deviations of a binomial share above the level.
void expect_level(const Shares& shares, const std::string& effect, int replicates) {
  const double n = replicates;
  EXPECT_LT(shares.at(effect)[0], 0.05 + 3.0 * std::sqrt(0.05 / n)) << effect;
  EXPECT_LT(shares.at(effect)[1], 0.01 + 3.0 * std::sqrt(0.01 / n)) << effect;
}

TEST(NoiseTests, hold_their_level_on_white_noise) {
  const Shares shares = alarms(500, [](std::uint64_t seed) { return series(2100, {}, seed); });
  EXPECT_EQ(shares.size(), 6u);
  for (const auto& [effect, share] : shares) expect_level(shares, effect, 500);
  // And do not waste it: of the tests whose null distribution is continuous.
  EXPECT_GT(shares.at("correlated_noise")[0], 0.02);
}

TEST(NoiseTests, hold_their_level_on_high_passed_noise) {
  const Shares shares =
      alarms(500, [](std::uint64_t seed) { return followed(series(2100, {}, seed)); });
  EXPECT_EQ(shares.size(), 3u);
  for (const auto& [effect, share] : shares) expect_level(shares, effect, 500);
}

TEST(NoiseTests, heavy_tails_are_neither_colour_nor_lines) {
  const Shares shares = alarms(150, [](std::uint64_t seed) { return heavy_tailed(3000, seed); });
  expect_level(shares, "correlated_noise", 150);
  expect_level(shares, "mains_interference", 150);
  EXPECT_GT(shares.at("outliers")[1], 0.99);
  const Shares fast =
      alarms(150, [](std::uint64_t seed) { return followed(heavy_tailed(3000, seed)); });
  expect_level(fast, "correlated_noise", 150);
}

TEST(NoiseTests, colour_is_neither_outliers_nor_lines) {
  for (const double rho : {0.5, 0.95}) {
    NoiseShape shape;
    shape.correlation = rho;
    const Shares shares =
        alarms(100, [&](std::uint64_t seed) { return series(3000, shape, seed); });
    expect_level(shares, "outliers", 100);
    expect_level(shares, "mains_interference", 100);
    EXPECT_GT(shares.at("correlated_noise")[1], 0.99);
  }
}

TEST(NoiseTests, find_what_the_likelihood_ratio_would_find) {
  // Of 6000 samples, three axes: the correlation's standard deviation is 0.0075; 0.03 is four.
  NoiseShape correlated, larger, wild;
  correlated.correlation = 0.03;
  const auto found = [](const NoiseShape& shape, const std::string& effect) {
    return alarms(40, [&](std::uint64_t seed) { return series(6000, shape, seed); })[effect][1];
  };
  EXPECT_GT(found(correlated, "correlated_noise"), 0.85);
  larger.scale = 1.05;  // 0.5 % is one standard deviation, 2 % are allowed
  EXPECT_GT(found(larger, "noise_scale"), 0.95);
  wild.outlier_probability = 0.002;  // a dozen
  wild.outlier_size = 6.0;
  EXPECT_GT(found(wild, "outliers"), 0.95);
  // Those that hardly stick out show in white residuals themselves; high-passed, in few of them.
  wild.outlier_probability = 0.01;
  wild.outlier_size = 1.6;
  EXPECT_GT(found(wild, "outliers"), 0.9);
}

TEST(NoiseTests, find_a_line_that_cannot_be_seen) {
  // |a|^2 + |d|^2 = (0.12 sigma)^2: the periodogram's mean is 86 + 6, what is needed about 45.
  const Shares shares = alarms(40, [](std::uint64_t seed) {
    SampleResiduals r = series(12000, {}, seed);
    const Mains mains{0.12 * kSigma * Vector3(0.6, 0.0, 0.3),
                      0.12 * kSigma * Vector3(0.0, 0.7, 0.25), 20.0 + 0.011 * double(seed)};
    for (std::size_t k = 0; k < r.t.size(); ++k) {
      r.residual[k] += mains.at(r.t[k]);
      r.reading[k] += mains.at(r.t[k]);
    }
    return r;
  });
  EXPECT_GT(shares.at("mains_interference")[1], 0.95);
}

}  // namespace
}  // namespace magimu
