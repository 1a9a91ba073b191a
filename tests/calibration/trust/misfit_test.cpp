// SPDX-License-Identifier: BSD-3-Clause
// Of a magnetometer that departs from what the gyroscope says: which of the two is named.
#include <gmock/gmock.h>

#include "calibration/trust/trust.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

// Reasons of a fit that leaves 12 uT of 50, in 4000 samples of which one in ten is new.
std::vector<std::string> reasons(double off_ellipsoid_uT, double at_rest_uT) {
  Calibration c;
  c.strength_uT = 50.0;
  c.residuals[2] = {.rms = 10.0, .lag1 = 0.9, .rms_unit = 12.0};
  c.residual_series.resize(3);
  RandomStream random(1, RandomPurpose::kMotion);
  for (int k = 0; k < 4000; ++k) {
    c.residual_series[2].t.push_back(0.01 * k);
    c.residual_series[2].whitened.push_back(10.0 * random.normal3());
  }
  KnownOfMisfit known;
  known.off_ellipsoid_uT = off_ellipsoid_uT;
  known.at_rest_uT = at_rest_uT;
  judge(c, {}, known);
  return c.trust.reasons;
}

TEST(Misfit, of_directions_alone_is_the_gyroscopes) {
  EXPECT_THAT(reasons(0.4, 0.35), Contains(HasSubstr("directions do not turn as the gyroscope")));
}

// A current of the device is in the readings at rest as well.
TEST(Misfit, whose_lengths_noise_hides_names_both_sensors) {
  EXPECT_THAT(reasons(7.7, 8.5),
              Contains(AllOf(HasSubstr("Which of the two is wrong"), HasSubstr("the current of"),
                             HasSubstr("at the gyroscope (a high-pass"))));
}

TEST(Misfit, of_lengths_as_well_is_the_fields_or_the_magnetometers) {
  EXPECT_THAT(reasons(7.7, 0.35), Contains(HasSubstr("departs from one homogeneous field")));
}

}  // namespace
}  // namespace magimu
