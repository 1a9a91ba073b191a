// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/residual_statistics.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

namespace magimu::apps {
namespace {

std::vector<Vector3> noise(int n, double memory) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<Vector3> out;
  Vector3 last = Vector3::Zero();
  for (int k = 0; k < n; ++k) {
    const Vector3 white(normal(random), normal(random), normal(random));
    last = memory * last + std::sqrt(1.0 - memory * memory) * white;
    out.push_back(last);
  }
  return out;
}

TEST(Autocorrelation, of_noise_with_memory_falls_by_it_from_lag_to_lag) {
  const Curve c = autocorrelation(noise(40000, 0.8), 0.01, 5);
  ASSERT_EQ(c.x.size(), 5u);
  EXPECT_DOUBLE_EQ(c.x[0], 0.01);
  for (std::size_t lag = 1; lag <= 5; ++lag) {
    EXPECT_NEAR(c.y[lag - 1], std::pow(0.8, double(lag)), 0.03);
  }
}

TEST(Spectrum, of_white_noise_is_one) {
  for (const int n : {3000, 4096, 5000}) {
    const Curve c = spectrum(noise(n, 0.0), 0.01, 5);
    ASSERT_GT(c.x.size(), 8u);
    EXPECT_LE(c.x.back(), 50.0);
    for (std::size_t i = c.x.size() - 5; i < c.x.size(); ++i) EXPECT_NEAR(c.y[i], 1.0, 0.2);
  }
}

TEST(Spectrum, has_a_peak_where_the_residual_swings) {
  std::vector<Vector3> v = noise(8192, 0.0);
  for (std::size_t k = 0; k < v.size(); ++k) {
    v[k][1] += std::sin(2.0 * std::numbers::pi * 7.0 * 0.01 * double(k));
  }
  const Curve c = spectrum(v, 0.01, 40);
  const auto peak = std::max_element(c.y.begin(), c.y.end()) - c.y.begin();
  EXPECT_NEAR(c.x[std::size_t(peak)], 7.0, 0.4);
}

TEST(Spectrum, of_too_little_is_nothing) {
  EXPECT_TRUE(spectrum({}, 0.01).x.empty());
  EXPECT_TRUE(spectrum(noise(100, 0.0), 0.0).x.empty());
  EXPECT_TRUE(autocorrelation({}, 0.01, 10).x.empty());
  EXPECT_EQ(median_interval({}), 0.0);
}

TEST(Envelope, keeps_extremes_and_gaps) {
  std::vector<double> t, y;
  for (int k = 0; k < 10000; ++k) {
    t.push_back(0.01 * k + (k >= 5000 ? 20.0 : 0.0));
    y.push_back(k == 3333 ? 9.0 : k == 7777 ? -8.0 : 0.001 * (k % 7));
  }
  const Curve c = envelope(t, y, 100);
  EXPECT_LT(c.x.size(), 250u);
  EXPECT_EQ(*std::max_element(c.y.begin(), c.y.begin() + 80), 9.0);
  EXPECT_THAT(c.y, testing::Contains(-8.0));
  EXPECT_EQ(std::count_if(c.y.begin(), c.y.end(), [](double v) { return std::isnan(v); }), 1);
}

TEST(Envelope, of_few_samples_is_all_of_them) {
  const Curve c = envelope({0.0, 1.0, 2.0}, {5.0, 4.0, 6.0}, 100);
  EXPECT_THAT(c.y, testing::ElementsAre(5.0, 4.0, 6.0));
}

}  // namespace
}  // namespace magimu::apps
