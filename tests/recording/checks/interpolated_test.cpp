// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/interpolated.h"

#include <gmock/gmock.h>

#include <cmath>

#include "recording/checks/quality.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

Vector3 field(double t) {
  return 40.0 * Vector3(std::sin(1.1 * t), std::cos(0.7 * t), std::sin(1.7 * t + 0.3));
}

VectorSeries noisy(double rate_hz, double seconds) {
  RandomStream random(1, RandomPurpose::kMotion);
  VectorSeries out;
  for (int k = 0; double(k) <= rate_hz * seconds; ++k) {
    out.push_back(0.0031 + k / rate_hz, field(k / rate_hz) + 0.3 * random.normal3());
  }
  return out;
}

// Onto a row every 1/104 s, with so many decimals.
VectorSeries onto_rows(const VectorSeries& own, int decimals) {
  const double step = std::pow(10.0, -decimals);
  VectorSeries out;
  std::size_t j = 0;
  for (int k = 0; k / 104.0 < own.t.back(); ++k) {
    const double t = k / 104.0;
    if (t < own.t.front()) continue;
    while (own.t[j + 1] < t) ++j;
    const double w = (t - own.t[j]) / (own.t[j + 1] - own.t[j]);
    const Vector3 v = (1.0 - w) * own.v[j] + w * own.v[j + 1];
    out.push_back(t, (v / step).array().round() * step);
  }
  return out;
}

TEST(Interpolated, readings_come_back_with_their_times) {
  for (const double rate_hz : {10.0, 15.0, 20.0, 25.0, 50.0}) {
    SCOPED_TRACE(rate_hz);
    const VectorSeries own = noisy(rate_hz, 40.0);
    const auto found = readings_of_lines(onto_rows(own, 5));
    ASSERT_TRUE(found.has_value());
    // Every one but the first and the last, and those at which the line goes on by chance.
    EXPECT_NEAR(double(found->size()), double(own.size()), 0.02 * double(own.size()) + 3.0);
    EXPECT_NEAR(found->rate_hz(), rate_hz, 0.01 * rate_hz);
    std::size_t j = 0;
    for (std::size_t i = 0; i < found->size(); ++i) {
      while (j + 1 < own.size() && own.t[j] < found->t[i] - 0.5 / rate_hz) ++j;
      // Where a line goes on with nearly the same slope: less than the noise of 0.3.
      EXPECT_NEAR(found->t[i], own.t[j], 3e-3);
      EXPECT_LT((found->v[i] - own.v[j]).norm(), 0.1);
    }
  }
}

TEST(Interpolated, readings_on_the_rows_themselves_come_back) {
  VectorSeries own;
  for (const double t : noisy(26.0, 30.0).t)
    own.push_back(std::round(t * 104.0) / 104.0, Vector3::Zero());
  RandomStream random(2, RandomPurpose::kMotion);
  for (std::size_t j = 0; j < own.size(); ++j) own.v[j] = field(own.t[j]) + 0.3 * random.normal3();
  const auto found = readings_of_lines(onto_rows(own, 4));
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->rate_hz(), 26.0, 0.3);
}

TEST(Interpolated, measured_samples_are_none) {
  EXPECT_FALSE(readings_of_lines(noisy(104.0, 40.0)).has_value());
  EXPECT_FALSE(readings_of_lines({}).has_value());
  VectorSeries smooth, coarse = noisy(104.0, 40.0);
  for (const double t : coarse.t) smooth.push_back(t, field(t));
  EXPECT_FALSE(readings_of_lines(smooth).has_value()) << "no noise at all";
  for (Vector3& v : coarse.v) v = (v / 0.15).array().round() * 0.15;
  EXPECT_FALSE(readings_of_lines(coarse).has_value());
}

// Faster than half the rows some lines have one sample, which tells nothing of its line.
TEST(Interpolated, readings_faster_than_every_second_row_are_not_looked_for) {
  EXPECT_FALSE(readings_of_lines(onto_rows(noisy(80.0, 40.0), 5)).has_value());
}

TEST(Interpolated, magnetometers_are_told_of_with_their_own_rate) {
  RandomStream random(3, RandomPurpose::kMotion);
  Recording r;
  r.mag_names = {"mag"};
  r.mag = {onto_rows(noisy(50.0, 40.0), 5)};
  for (const double t : r.mag[0].t) {
    r.acc.push_back(t, Vector3(std::sin(t), std::cos(t), 9.7) + 0.02 * random.normal3());
    r.gyr.push_back(
        t, Vector3(std::sin(3 * t), std::cos(2 * t), std::sin(t)) + 0.002 * random.normal3());
  }
  std::string said;
  for (const Issue& issue : check_recording(r)) {
    if (issue.kind == "interpolation") said += issue.text();
  }
  EXPECT_THAT(said, testing::AllOf(testing::HasSubstr("a clock of about 50 Hz"),
                                   testing::HasSubstr("at which the lines meet, and no others")));
}

}  // namespace
}  // namespace magimu
