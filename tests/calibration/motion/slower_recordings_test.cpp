// SPDX-License-Identifier: BSD-3-Clause
// Fast recordings are calibrated from means of neighbouring samples, and nothing is lost by it.
#include "tests/calibration/cases.h"

#include "calibration/motion/integrated_rotation.h"
#include "calibration/motion/slower_recordings.h"

namespace magimu {
namespace {

TEST(SlowerRecordings, of_slow_sensors_are_these_themselves) {
  const Simulation s = test::simulated_hand(280.0, 1, 10.0);
  const SlowerRecordings slower({&s.recording});
  EXPECT_EQ(slower.get().front(), &s.recording);
}

// Accelerometer and magnetometer show in the middle of a group what the middle's sample shows, of a
// sensor that turns in circles about an axis that turns, too.
TEST(SlowerRecordings, show_what_turns_at_its_full_size) {
  constexpr double kRate = 1000.0;
  constexpr SlowerRates kSlower{150.0, 75.0};  // 13 samples in one
  const Vector3 up(0.0, 0.0, 9.8), field(0.0, 20.0, -40.0), bias(30.0, -20.0, 10.0);
  Recording r;
  r.mag.resize(1);
  Rot3 nRb;
  for (int k = 0; k < 4000; ++k) {
    const double t = k / kRate;
    const Vector3 w(4.0 * std::cos(5.0 * t), 4.0 * std::sin(5.0 * t), 2.0);
    r.gyr.push_back(t, w);
    r.acc.push_back(t, nRb.matrix().transpose() * up);
    r.mag.front().push_back(t, nRb.matrix().transpose() * field + bias);
    nRb = (nRb * Rot3::Exp(w / kRate)).normalized();
  }
  const Recording slower = slower_recording(r, kSlower);
  ASSERT_EQ(samples_in_one(r.acc, kSlower), 13U);
  const double T = 13.0 / kRate, plain = std::pow(6.0 * T, 2) / 24.0;  // what a plain mean loses
  const IntegratedRotation all(r.gyr, Vector3::Zero()), few(slower.gyr, Vector3::Zero());
  double acc = 0.0, mag = 0.0, turned = 0.0;
  for (std::size_t k = 5; k + 5 < r.acc.size() / 13; ++k) {
    const std::size_t middle = 13 * k + 6;
    EXPECT_NEAR(slower.acc.t[k], r.acc.t[middle], 1e-9);
    acc = std::max(acc, (slower.acc.v[k] - r.acc.v[middle]).norm() / up.norm());
    mag = std::max(mag, (slower.mag[0].v[k] - r.mag[0].v[middle]).norm() / field.norm());
    const double t = slower.gyr.t[k];
    turned = std::max(turned, (all.at(t).inverse() * few.at(t)).Log().norm());
  }
  EXPECT_LT(acc, 0.02 * plain);
  EXPECT_LT(mag, 0.1 * plain);
  EXPECT_LT(turned, 1e-9);
}

TEST(SlowerRecordings, leave_gaps_alone) {
  Recording r;
  for (int k = 0; k < 100; ++k) {
    if (k < 33 || k > 40) r.gyr.push_back(1e-3 * k, Vector3(k, 0.0, 0.0));
  }
  const VectorSeries means = slower_recording(r, {300.0, 200.0}).gyr;  // 5 samples in one
  double turned = 0.0, all = 0.0;                                      // up to the gap
  for (std::size_t k = 0; k + 1 < means.size() && means.t[k + 1] < 0.0325; ++k) {
    turned += means.v[k].x() * (means.t[k + 1] - means.t[k]);
  }
  for (int k = 0; k < 32; ++k) all += 1e-3 * k;
  EXPECT_NEAR(turned, all, 1e-9);
  for (std::size_t k = 0; k < means.size(); ++k) {
    // A mean whose group had the gap in it would be at one of its ends with the other end's rate.
    const double first = 1e3 * means.t[k], mean = means.v[k].x();
    EXPECT_TRUE(std::abs(mean - first) < 1e-6 || std::abs(mean - first - 2.0) < 1e-6) << first;
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
