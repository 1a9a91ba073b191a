// SPDX-License-Identifier: BSD-3-Clause
// From how far away the optimum is found.
#include <Eigen/LU>

#include "tests/calibration/cases.h"

namespace magimu {
namespace {

using test::sigmas_apart;

constexpr double kSame = 1e-3;  // standard deviations

class FromAWrongGyroscopeBias : public testing::TestWithParam<double> {};

TEST_P(FromAWrongGyroscopeBias, every_direction_leads_to_the_same_optimum) {
  const Simulation s = test::simulated_hand(50.0, 3, 60.0);
  CalibrationOptions options = test::same_model_and_noise(s, 4);
  const Calibration searched = calibrate(s.recording, options);
  test::expect_consistent(searched, s.truth.parameters);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Vector3 error = sign * GetParam() * Vector3::Unit(axis);
      options.initialization.gyr_bias = s.truth.parameters.gyr_bias + error;
      const Calibration started = calibrate(s.recording, options);
      EXPECT_TRUE(started.fit.converged()) << started.fit.message;
      EXPECT_LT(sigmas_apart(searched, started), kSame) << "start off by " << error.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Convergence, FromAWrongGyroscopeBias, testing::Values(1e-3, 1e-2, 1e-1));

TEST(Convergence, the_start_of_the_dip_does_not_matter) {
  const Simulation s = test::simulated_hand(50.0, 4, 60.0);
  CalibrationOptions options = test::same_model_and_noise(s, 4);
  const Calibration searched = calibrate(s.recording, options);
  for (const double dip_deg : {-80.0, -30.0, 0.0, 30.0, 89.0}) {
    options.initialization.dip_rad = dip_deg * kDegree;
    const Calibration started = calibrate(s.recording, options);
    EXPECT_LT(sigmas_apart(searched, started), kSame) << "start at " << dip_deg << " deg";
  }
}

TEST(Convergence, a_large_bias_is_found_where_there_are_no_rests) {
  Simulation s = test::simulated_paper(10.0, 2);
  const Vector3 more(0.1, -0.15, 0.2);
  for (Vector3& rate : s.recording.gyr.v) rate += more;
  s.truth.parameters.gyr_bias += more;
  test::expect_consistent(calibrate(s.recording, test::same_model_and_noise(s)),
                          s.truth.parameters);
}

}  // namespace
}  // namespace magimu
