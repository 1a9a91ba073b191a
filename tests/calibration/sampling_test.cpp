// SPDX-License-Identifier: BSD-3-Clause
// Rates, ratios, clocks out of step, arrays: the result has to be right whatever the sampling.
#include "calibration/pipeline.h"
#include "sim/draws/random.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

using test::expect_consistent;
using test::same_model_and_noise;
using test::simulated_hand;

TEST(BlockMeans, eight_samples_a_node_lose_next_to_nothing) {
  const Simulation s = test::simulated_paper(80.0);
  const Calibration all = calibrate(s.recording, same_model_and_noise(s, 1));
  const Calibration means = calibrate(s.recording, same_model_and_noise(s, 8));
  EXPECT_EQ(all.nodes, int(s.recording.gyr.size()));
  EXPECT_EQ(means.nodes, (all.nodes + 7) / 8);
  EXPECT_LT(test::sigmas_apart(all, means), 0.3);
  const VectorXd ratio =
      (means.covariance_model.diagonal().array() / all.covariance_model.diagonal().array()).sqrt();
  EXPECT_GT(ratio.minCoeff(), 0.99);
  EXPECT_LT(ratio.maxCoeff(), 1.02);
}

class HandMotionAt : public testing::TestWithParam<double> {};

TEST_P(HandMotionAt, errors_are_as_the_covariance_says) {
  const Simulation s = simulated_hand(GetParam(), 5);
  expect_consistent(calibrate(s.recording, same_model_and_noise(s)), s.truth.parameters);
}

INSTANTIATE_TEST_SUITE_P(Rates, HandMotionAt, testing::Values(25.0, 60.0, 100.0, 286.0, 500.0));

class MagnetometerSlowerBy : public testing::TestWithParam<int> {};

TEST_P(MagnetometerSlowerBy, errors_are_as_the_covariance_says) {
  const Simulation s = simulated_hand(100.0, 6, 60.0, GetParam());
  const Calibration c = calibrate(s.recording, same_model_and_noise(s));
  EXPECT_EQ(c.nodes, int(s.recording.mag.front().size()));
  expect_consistent(c, s.truth.parameters);
}

INSTANTIATE_TEST_SUITE_P(Ratios, MagnetometerSlowerBy, testing::Values(2, 4, 8));

// The magnetometer's samples moved by a fraction of the IMU's interval, made anew from the truth:
// the attitude in between is the one the sample's own mean rate leads to.
void shift_magnetometer(Simulation& s, double fraction) {
  const SensorParameters& p = s.truth.parameters;
  VectorSeries& mag = s.recording.mag.front();
  const double dt = s.truth.t[1] - s.truth.t[0];
  const double sigma = s.truth.noise.mag * std::sqrt(mag.rate_hz());
  RandomStream random(99, RandomPurpose::kMagnetometerNoise);
  VectorSeries shifted;
  for (std::size_t k = 0; k + 1 < s.truth.t.size(); ++k) {
    const Vector3 turn = (s.truth.nRb[k].inverse() * s.truth.nRb[k + 1]).Log();
    const Rot3 nRb = s.truth.nRb[k] * Rot3::Exp(fraction * turn);
    const Vector3 exact =
        magnetometer_model(nRb, p.mag.front().distortion, p.mag.front().bias, p.dip_rad);
    shifted.push_back(s.truth.t[k] + fraction * dt, exact + sigma * random.normal3());
  }
  mag = shifted;
}

class MagnetometerOutOfStepBy : public testing::TestWithParam<double> {};

TEST_P(MagnetometerOutOfStepBy, errors_are_as_the_covariance_says) {
  Simulation s = simulated_hand(50.0, 7, 80.0);
  shift_magnetometer(s, GetParam());
  expect_consistent(calibrate(s.recording, same_model_and_noise(s)), s.truth.parameters);
  expect_consistent(calibrate(s.recording, same_model_and_noise(s, 5)), s.truth.parameters);
}

INSTANTIATE_TEST_SUITE_P(Fractions, MagnetometerOutOfStepBy, testing::Values(0.1, 0.37, 0.9));

// Read four times as often as it measures: as if each sample had come once, and said.
TEST(MagnetometerThatRepeats, is_taken_at_its_own_rate) {
  const Simulation s = test::simulated_hand(100.0, 2, 60.0, 4);
  Recording repeated = s.recording;
  repeated.mag[0] = {};
  for (std::size_t k = 0; k < s.recording.gyr.size(); ++k) {
    repeated.mag[0].push_back(s.recording.gyr.t[k], s.recording.mag[0].v[k / 4]);
  }
  const CalibrationOptions options = test::same_model(s, 1);
  const Calibration once = calibrate(s.recording, options), four = calibrate(repeated, options);
  EXPECT_TRUE(once.warnings.empty());
  ASSERT_EQ(four.warnings.size(), 1u);
  EXPECT_NE(four.warnings[0].find("75 % of the samples"), std::string::npos) << four.warnings[0];
  EXPECT_EQ(in_calibration_order(once), in_calibration_order(four));
  EXPECT_EQ(once.covariance, four.covariance);
}

// One sample in twenty came twice: as old as it is it would count as a lag of 0.5 ms.
TEST(MagnetometerThatRepeats, is_taken_without_the_few_that_came_twice) {
  const Simulation s = test::simulated_hand(100.0, 2, 60.0);
  Recording some = s.recording, without = s.recording;
  VectorSeries &repeated = some.mag[0], &left = without.mag[0];
  left = {};
  for (std::size_t k = 0; k < repeated.size(); ++k) {
    if (k % 20 == 7) {
      repeated.v[k] = repeated.v[k - 1];
    } else {
      left.push_back(repeated.t[k], repeated.v[k]);
    }
  }
  const CalibrationOptions options = test::same_model(s, 1);
  const Calibration c = calibrate(some, options), same = calibrate(without, options);
  ASSERT_EQ(c.warnings.size(), 1u);
  EXPECT_NE(c.warnings[0].find("5 % of the samples"), std::string::npos) << c.warnings[0];
  EXPECT_EQ(in_calibration_order(c), in_calibration_order(same));
}

TEST(Array, three_magnetometers_are_calibrated_together) {
  const Simulation s = simulated_hand(50.0, 8, 60.0, 1, 3);
  const Calibration c = calibrate(s.recording, same_model_and_noise(s));
  ASSERT_EQ(c.parameters.mag.size(), 3U);
  EXPECT_EQ(c.mag_names, (std::vector<std::string>{"mag1", "mag2", "mag3"}));
  EXPECT_EQ(c.order.size(), 6U + 3U * 12U + 1U);
  expect_consistent(c, s.truth.parameters);

  Recording first_only = s.recording;
  first_only.mag.resize(1);
  first_only.mag_names.resize(1);
  const Calibration alone = calibrate(first_only, same_model_and_noise(s));
  EXPECT_LT(c.sigma_model("gyroscope.bias[0]"), alone.sigma_model("gyroscope.bias[0]"));
}

TEST(Array, magnetometers_may_have_clocks_and_rates_of_their_own) {
  Simulation s = simulated_hand(50.0, 9, 60.0, 1, 2);
  VectorSeries& second = s.recording.mag[1];
  VectorSeries thinned;
  for (std::size_t k = 1; k < second.size(); k += 3) thinned.push_back(second.t[k], second.v[k]);
  second = thinned;  // a third of the samples at the same noise a sample: less information
  CalibrationOptions options = same_model_and_noise(s);
  const Calibration c = calibrate(s.recording, options);
  EXPECT_TRUE(c.fit.converged()) << c.fit.message;
  EXPECT_LT(
      test::sigmas_apart(c, in_calibration_order(s.truth.parameters, {s.truth.parameters.dip_rad})),
      8.0);  // its density is now 1.7 times the one given
}

TEST(Sampling, long_recordings_have_fewer_nodes_a_second) {
  const Recording r = test::simulated_hand(100.0, 7, 650.0).recording;
  const std::vector<const Recording*> once{&r}, often(4, &r);
  const Pipeline one(once, {});
  EXPECT_EQ(one.node_every(), 2);  // 65,000 samples, 60,000 nodes at the most
  EXPECT_EQ(one.coarse_every(), 9);
  const Pipeline four(often, {});
  EXPECT_EQ(four.node_every(), 5);
  EXPECT_EQ(four.coarse_every(), 9);
  const std::vector<const Recording*> very_often(10, &r);
  EXPECT_EQ(Pipeline(very_often, {}).coarse_every(), 15);
}

}  // namespace
}  // namespace magimu
