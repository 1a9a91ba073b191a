// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/high_pass.h"

#include <gtest/gtest.h>

#include <cmath>

#include "factors/effects/noise_effects.h"

namespace magimu {
namespace {

// r_l of the header, of white noise of variance 1.
double high_pass_autocovariance(int lag) {
  double r = (lag == 0 ? 1.0 : 0.0) - 2.0 * smoothing_weight(lag);
  for (int j = -kHighPassReach; j <= kHighPassReach; ++j) {
    r += smoothing_weight(j) * smoothing_weight(j + lag);
  }
  return r;
}

TEST(HighPass, takes_quadratics_away_also_at_the_ends_and_beside_gaps) {
  VectorSeries series;
  for (int k = 0; k < 60; ++k) {
    if (k > 30 && k < 37) continue;
    const double t = 5.0 + 0.01 * k;
    series.push_back(t, Vector3(1.0 - 3.0 * t, 40.0 * t * t, 7.0));
  }
  for (const Vector3& v : high_passed(series)) EXPECT_LT(v.norm(), 1e-9);
}

TEST(HighPass, leaves_of_white_noise_what_its_header_says) {
  std::vector<Vector3> noise(60000, Vector3::Zero());
  add_noise(noise, 2.0, {}, 1);
  const std::vector<Vector3> passed = high_passed(noise);
  for (int lag = 0; lag <= 10; ++lag) {
    double sum = 0.0;
    for (std::size_t k = 100; k + 100 < noise.size(); ++k) {
      sum += passed[k].dot(passed[k + std::size_t(lag)]);
    }
    const double r = sum / (3.0 * 4.0 * double(noise.size() - 200));
    EXPECT_NEAR(r, high_pass_autocovariance(lag), 0.012) << lag;
  }
  EXPECT_NEAR(high_pass_autocovariance(0), kHighPassVariance, 1e-12);
  EXPECT_NEAR(high_pass_autocovariance(1) / kHighPassVariance, -0.349, 5e-4);
  EXPECT_NEAR(high_pass_autocovariance(4) / kHighPassVariance, 0.258, 5e-4);
}

TEST(HighPass, gain_is_the_transform_of_the_autocovariance) {
  for (const double omega : {0.0, 0.3, 1.0, 2.0, 3.0}) {
    double sum = high_pass_autocovariance(0);
    for (int lag = 1; lag <= 8; ++lag) {
      sum += 2.0 * high_pass_autocovariance(lag) * std::cos(lag * omega);
    }
    EXPECT_NEAR(high_pass_gain(omega), sum, 1e-12);
  }
}

TEST(HighPass, gives_zeros_for_fewer_samples_than_its_window) {
  EXPECT_EQ(high_passed(std::vector<Vector3>(8, Vector3::Ones())).at(3), Vector3::Zero());
}

}  // namespace
}  // namespace magimu
