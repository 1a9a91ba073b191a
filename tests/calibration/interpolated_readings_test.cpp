// SPDX-License-Identifier: BSD-3-Clause
// A magnetometer that a logger has interpolated to its rows: a calibration has the readings alone.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "calibration/pipeline.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

// It swings about an axis of its own. What a field that is fixed in space reads then, and the rate.
const Vector3 kAxis = Vector3(1.0, 2.0, -1.0).normalized();
Vector3 turned(const Vector3& v, double t) {
  return Eigen::AngleAxisd(-3.0 * std::sin(0.9 * t), kAxis) * v;
}
Vector3 rate(double t) { return 2.7 * std::cos(0.9 * t) * kAxis; }

// The magnetometer of 20 Hz, on straight lines to rows at 104 Hz, with five decimals.
Recording interpolated_recording() {
  RandomStream random(1, RandomPurpose::kMotion);
  Recording r;
  r.name = "lines.csv";
  r.mag_names = {"mag"};
  r.mag.resize(1);
  VectorSeries own;
  for (int k = 0; k <= 800; ++k) {
    const double t = k / 20.0 + 0.0031;
    own.push_back(t, turned({0.0, 25.0, -43.0}, t) + 0.3 * random.normal3());
  }
  std::size_t j = 0;
  for (int k = 1; k < 4160; ++k) {
    const double t = k / 104.0;
    while (own.t[j + 1] < t) ++j;
    const double w = (t - own.t[j]) / (own.t[j + 1] - own.t[j]);
    const Vector3 v = (1.0 - w) * own.v[j] + w * own.v[j + 1];
    r.mag[0].push_back(t, (v * 1e5).array().round() / 1e5);
    r.acc.push_back(t, turned({0.0, 0.0, 9.8}, t) + 0.02 * random.normal3());
    r.gyr.push_back(t, rate(t) + 0.002 * random.normal3());
  }
  return r;
}

TEST(InterpolatedReadings, alone_are_used_and_a_warning_tells) {
  const Recording r = interpolated_recording();
  const CheckedRecordings checked({&r});
  ASSERT_EQ(checked.get().size(), 1U);
  EXPECT_EQ(checked.get().front()->acc.size(), r.acc.size());
  EXPECT_NEAR(double(checked.get().front()->mag[0].size()), 800.0, 20.0);
  EXPECT_THAT(checked.warnings(),
              testing::Contains(testing::HasSubstr("at which the lines meet, and no others")));
}

}  // namespace
}  // namespace magimu
