// SPDX-License-Identifier: BSD-3-Clause
// Statistics of noise, outliers, drift; quantization, clipping, repetition.
#include "tests/oracle/degrade.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/oracle/random.h"
#include "tests/oracle/sensors.h"

namespace magimu::oracle {
namespace {

using Samples = std::vector<Eigen::Vector3d>;

Samples degraded(const std::vector<Effect>& effects, double sigma = 2.0, std::size_t n = 40000) {
  Samples samples(n, Eigen::Vector3d(1.0, -2.0, 3.0));
  degrade(samples, Channel::kMag, sigma, effects, 17);
  for (Eigen::Vector3d& sample : samples) sample -= Eigen::Vector3d(1.0, -2.0, 3.0);
  return samples;
}

double variance(const Samples& samples) {
  double sum = 0.0;
  for (const Eigen::Vector3d& sample : samples) sum += sample.squaredNorm();
  return sum / (3.0 * static_cast<double>(samples.size()));
}

double correlation(const Samples& samples, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t k = lag; k < samples.size(); ++k) sum += samples[k].dot(samples[k - lag]);
  return sum / (3.0 * static_cast<double>(samples.size() - lag)) / variance(samples);
}

TEST(Random, streams_of_one_seed_are_independent) {
  Random a(3, Stream::kNoise, 0), b(3, Stream::kNoise, 1), c(4, Stream::kNoise, 0);
  double ab = 0.0, ac = 0.0, mean = 0.0;
  for (int i = 0; i < 40000; ++i) {
    const double x = a.normal();
    mean += x / 40000;
    ab += x * b.normal() / 40000;
    ac += x * c.normal() / 40000;
  }
  EXPECT_NEAR(mean, 0.0, 0.02);
  EXPECT_NEAR(ab, 0.0, 0.02);
  EXPECT_NEAR(ac, 0.0, 0.02);
}

TEST(Degrade, noise_scale_multiplies_sigma) {
  EXPECT_NEAR(variance(degraded({})), 4.0, 0.1);
  EXPECT_NEAR(variance(degraded({make_effect("noise_scale", {1.5})})), 9.0, 0.2);
  EXPECT_EQ(variance(degraded({make_effect("noise_scale", {1.5})}, 0.0)), 0.0);
}

TEST(Degrade, correlated_noise_keeps_its_size_and_decays_by_rho_a_sample) {
  const Samples e = degraded({make_effect("correlated_noise", {0.8})});
  EXPECT_NEAR(variance(e), 4.0, 0.2);
  EXPECT_NEAR(correlation(e, 1), 0.8, 0.02);
  EXPECT_NEAR(correlation(e, 3), 0.512, 0.03);
  EXPECT_NEAR(correlation(e, 30), 0.0, 0.03);
}

TEST(Degrade, outliers_hit_as_often_and_as_hard_as_told) {
  const Samples plain = degraded({}), hit = degraded({make_effect("outliers", {0.05, 20.0})});
  double squares = 0.0;
  int count = 0;
  for (std::size_t k = 0; k < plain.size(); ++k) {
    const Eigen::Vector3d error = hit[k] - plain[k];
    if (error.isZero(0.0)) continue;
    EXPECT_TRUE((error.array() != 0.0).all());
    ++count;
    squares += error.squaredNorm();
  }
  EXPECT_NEAR(count, 0.05 * 40000, 5.0 * std::sqrt(0.05 * 40000));
  EXPECT_NEAR(std::sqrt(squares / (3.0 * count)), 20.0 * 2.0, 2.0);
}

TEST(Degrade, quantization_comes_after_noise_and_clipping_last) {
  Samples samples(5000, Eigen::Vector3d(0.3, 9.0, -9.0));
  degrade(samples, Channel::kMag, 0.5,
          {make_effect("mag_saturation", {9.1}), make_effect("mag_quantization", {0.25})}, 3);
  int clipped = 0;
  for (const Eigen::Vector3d& sample : samples) {
    for (int i = 0; i < 3; ++i) {
      const bool at_end = std::abs(sample[i]) == 9.1;
      clipped += at_end;
      EXPECT_LE(std::abs(sample[i]), 9.1);
      EXPECT_TRUE(at_end || sample[i] == 0.25 * std::round(sample[i] / 0.25)) << sample[i];
    }
  }
  EXPECT_GT(clipped, 3000);
}

TEST(Degrade, repetition_repeats_whole_samples) {
  const Samples e = degraded({make_effect("sample_repetition", {0.3})});
  int repeated = 0;
  for (std::size_t k = 1; k < e.size(); ++k) repeated += e[k] == e[k - 1];
  EXPECT_NEAR(repeated, 0.3 * 40000, 500);
}

TEST(GyroBiasDrift, is_a_random_walk_of_its_density_and_the_truth_has_it) {
  constexpr double q = 1e-3;
  constexpr int kSeeds = 300;
  double half = 0.0, whole = 0.0, apart = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Options options;
    options.seed = seed;
    options.motion.kind = MotionKind::kStill;
    options.motion.duration_s = 8.0;
    options.rate_hz = 25.0;
    options.noise_factor = 0.0;
    options.effects = {make_effect("gyro_bias_drift", {q})};
    const Simulation s = simulate(options);
    half += s.truth.gyr_bias_drift[100].squaredNorm() / (3 * kSeeds);
    const Eigen::Vector3d reading = s.recording.gyr.v.back() - s.truth.device.gyr_bias;
    whole += reading.squaredNorm() / (3 * kSeeds);
    // The mean over [t, t + h) departs from the walk at t by q^2 h / 3 in variance.
    for (std::size_t k = 0; k < 200; ++k) {
      apart += (s.recording.gyr.v[k] - s.truth.device.gyr_bias - s.truth.gyr_bias_drift[k])
                   .squaredNorm() /
               (3 * kSeeds * 200);
    }
  }
  EXPECT_NEAR(half / (q * q * 4.0), 1.0, 0.25);
  EXPECT_NEAR(whole / (q * q * 8.0), 1.0, 0.25);
  EXPECT_NEAR(apart / (q * q * 0.04 / 3.0), 1.0, 0.05);
}

}  // namespace
}  // namespace magimu::oracle
