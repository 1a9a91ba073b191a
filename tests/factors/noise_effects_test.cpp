// SPDX-License-Identifier: BSD-3-Clause
#include "factors/effects/noise_effects.h"

#include <gtest/gtest.h>

#include <cmath>

namespace magimu {
namespace {

std::vector<Vector3> noise(const NoiseShape& shape, std::uint64_t seed = 1) {
  std::vector<Vector3> samples(40000, Vector3::Zero());
  add_noise(samples, 0.5, shape, seed);
  return samples;
}

double autocovariance(const std::vector<Vector3>& x, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t k = lag; k < x.size(); ++k) sum += x[k].dot(x[k - lag]);
  return sum / (3.0 * double(x.size() - lag));
}

TEST(NoiseEffects, white_noise_has_the_size_asked_for_and_no_memory) {
  const std::vector<Vector3> x = noise({});
  EXPECT_NEAR(autocovariance(x, 0), 0.25, 0.25 * 0.02);
  EXPECT_NEAR(autocovariance(x, 1), 0.0, 0.25 * 0.015);
  NoiseShape twice;
  twice.scale = 2.0;
  EXPECT_NEAR(noise(twice)[7].x(), 2.0 * x[7].x(), 1e-15);
  EXPECT_NE(noise({}, 2)[7], x[7]);
}

TEST(NoiseEffects, correlated_noise_keeps_its_size) {
  NoiseShape shape;
  shape.correlation = 0.8;
  const std::vector<Vector3> x = noise(shape);
  EXPECT_NEAR(autocovariance(x, 0), 0.25, 0.25 * 0.04);
  EXPECT_NEAR(autocovariance(x, 1) / autocovariance(x, 0), 0.8, 0.02);
  EXPECT_NEAR(autocovariance(x, 3) / autocovariance(x, 0), 0.512, 0.03);
}

TEST(NoiseEffects, outliers_hit_all_axes_of_a_sample_and_leave_the_others) {
  NoiseShape shape;
  shape.outlier_probability = 0.02;
  shape.outlier_size = 10.0;
  const std::vector<Vector3> plain = noise({}), x = noise(shape);
  int hits = 0;
  double square = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const Vector3 added = x[k] - plain[k];
    if (added.isZero(0.0)) continue;
    ++hits;
    EXPECT_TRUE((added.array() != 0.0).all());
    square += added.squaredNorm() / 3.0;
  }
  EXPECT_NEAR(hits, 800, 4 * 28);
  EXPECT_NEAR(square / hits, 25.0, 25.0 * 0.12);
}

TEST(NoiseEffects, mains_converter_and_neutral_parameters) {
  const Mains mains{Vector3(1, 2, 3), Vector3(4, 5, 6), 50.0};
  std::vector<Vector3> x = {mains.at(0.0), mains.at(0.005)};
  EXPECT_LT((x[0] - mains.a).norm(), 1e-12);
  EXPECT_LT((x[1] - mains.d).norm(), 1e-12);
  quantize(x, 0.3);
  EXPECT_LT((x[0] - Vector3(0.9, 2.1, 3.0)).norm(), 1e-12);
  saturate(x, 2.5);
  EXPECT_LT((x[0] - Vector3(0.9, 2.1, 2.5)).norm(), 1e-12);
  const std::vector<Vector3> before = x;
  quantize(x, 0.0);
  saturate(x, 1e300);
  EXPECT_EQ(x, before);
  EXPECT_EQ(Mains().at(0.005), Vector3::Zero());
}

}  // namespace
}  // namespace magimu
