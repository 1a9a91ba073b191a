// SPDX-License-Identifier: BSD-3-Clause
// Fast recordings are calibrated from means of neighbouring samples, and nothing is lost by it.
#include "tests/calibration/cases.h"

#include "calibration/motion/slower_recordings.h"

namespace magimu {
namespace {

TEST(SlowerRecordings, of_slow_sensors_are_these_themselves) {
  const Simulation s = test::simulated_hand(280.0, 1, 10.0);
  const SlowerRecordings slower({&s.recording});
  EXPECT_EQ(slower.get().front(), &s.recording);
}

TEST(SlowerRecordings, keep_what_the_gyroscope_integrates_to_and_leave_gaps_alone) {
  VectorSeries gyr;
  for (int k = 0; k < 100; ++k) {
    if (k < 33 || k > 40) gyr.push_back(1e-3 * k, Vector3(k, 0.0, 1.0));
  }
  const VectorSeries means = means_of_groups(gyr, 5, TimeOfMean::kFirst);
  double turned = 0.0, all = 0.0;  // up to the gap
  for (std::size_t k = 0; k + 1 < means.size() && means.t[k + 1] < 0.0325; ++k) {
    turned += means.v[k].x() * (means.t[k + 1] - means.t[k]);
  }
  for (int k = 0; k < 32; ++k) all += 1e-3 * k;
  EXPECT_NEAR(turned, all, 1e-12);
  for (std::size_t k = 0; k < means.size(); ++k) {
    // A mean whose group had the gap in it would be at one of its ends with the other end's rate.
    const double first = 1e3 * means.t[k], mean = means.v[k].x();
    EXPECT_TRUE(std::abs(mean - first) < 1e-9 || std::abs(mean - first - 2.0) < 1e-9) << first;
  }
}

TEST(SlowerRecordings, give_the_calibration_of_all_samples) {
  const Simulation s = test::simulated_hand(1000.0, 4, 60.0);
  CalibrationOptions options = test::same_model(s);
  const Calibration slower = calibrate(s.recording, options);
  options.node_every = slower.node_every;  // who says so gets all samples
  const Calibration all = calibrate(s.recording, options);
  EXPECT_EQ(slower.samples, all.samples);
  EXPECT_EQ(slower.samples, int(s.recording.gyr.size()));
  EXPECT_LT(test::sigmas_apart(all, slower), 0.3);
  EXPECT_NEAR(slower.noise.mag / all.noise.mag, 1.0, 0.02);
  // Of all samples, with nodes at 10 Hz, the gyroscope's comes out with a sigma of 5 % (eight
  // seeds).
  EXPECT_NEAR(slower.noise.gyr / s.truth.noise.gyr, 1.0, 0.02);
  EXPECT_NEAR(all.noise.gyr / s.truth.noise.gyr, 1.0, 0.165);  // 3.3 sigma
}

}  // namespace
}  // namespace magimu
