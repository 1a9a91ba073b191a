// SPDX-License-Identifier: BSD-3-Clause
// What the motion does not show of parts' tolerances: the sigmas must know of it, and must not grow
// where the motion shows that there is nothing.
#include "calibration/scan/unseen_tolerances.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>

#include "calibration/calibrate.h"
#include "calibration/fit/parameter_prior.h"
#include "factors/effects/effect.h"
#include "tests/calibration/truth_distance.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

// Of a family alone.
MatrixXd unseen(const MatrixXd& A, const VectorXd& z, const VectorXd& sigma) {
  return unseen_tolerances({tolerance_directions(A, z, 1.0, sigma)}).front();
}

TEST(UnseenTolerances, one_direction_is_what_its_densities_give) {
  for (const double lambda : {0.0, 0.3, 4.0, 1e4}) {
    for (const double sigmas : {0.0, 1.0, 3.0}) {
      constexpr double kSigma = 0.02;
      const double A = lambda / (kSigma * kSigma);
      const double y = sigmas * std::sqrt(lambda);  // in units of kSigma
      const MatrixXd got = unseen(MatrixXd::Constant(1, 1, A), VectorXd::Constant(1, y / kSigma),
                                  VectorXd::Constant(1, kSigma));
      // By sums over x of the densities themselves, in units of kSigma.
      double there = 0.0, second = 0.0;
      constexpr double kStep = 1e-4;
      for (double x = -6.0; x < 6.0; x += kStep) {
        const double prior = 3.0 * x * x * std::exp(-1.5 * x * x) * std::sqrt(1.5 / M_PI);
        const double p = prior * std::exp(y * x - 0.5 * lambda * x * x) * kStep;
        there += p;
        second += p * x * x;
      }
      const double expected = second / (1.0 + there) * kSigma * kSigma;
      EXPECT_NEAR(got(0, 0) / expected, 1.0, 1e-6) << lambda << " " << sigmas;
    }
  }
}

TEST(UnseenTolerances, where_nothing_shows_each_direction_has_one_half) {
  const VectorXd sigma = VectorXd::LinSpaced(9, 0.01, 0.09);
  const MatrixXd got = unseen(MatrixXd::Zero(9, 9), VectorXd::Zero(9), sigma);
  EXPECT_LT((got - 0.5 * MatrixXd(sigma.cwiseAbs2().asDiagonal())).norm(), 1e-14);
}

// Five directions known to a millionth of their tolerance and found to be zero: the sixth, of which
// nothing is known, has the odds of Laplace's rule of succession, one in seven. Those of another
// family count as well.
TEST(UnseenTolerances, of_an_otherwise_exact_device_the_rest_is_less_likely_to_be_wrong) {
  VectorXd information = VectorXd::Constant(6, 1e12);
  information[5] = 0.0;
  const VectorXd zero = VectorXd::Zero(6), one = VectorXd::Ones(6);
  const MatrixXd got = unseen(information.asDiagonal(), zero, one);
  EXPECT_NEAR(got(5, 5), 1.0 / 7.0, 1e-4);
  EXPECT_LT(got.topLeftCorner(5, 5).norm(), 1e-15);
  const ToleranceDirections exact =
      tolerance_directions(1e12 * MatrixXd::Identity(6, 6), zero, 1.0, one);
  const ToleranceDirections partly = tolerance_directions(information.asDiagonal(), zero, 1.0, one);
  EXPECT_NEAR(unseen_tolerances({partly, exact}).front()(5, 5), 1.0 / 13.0, 1e-4);
}

TEST(UnseenTolerances, what_the_data_show_counts_as_it_is) {
  const VectorXd z = VectorXd::Constant(1, 1e4), one = VectorXd::Ones(1);  // a hundred sigmas
  EXPECT_NEAR(unseen(MatrixXd::Constant(1, 1, 1e4), z, one)(0, 0), 1.0, 1e-3);
}

oracle::Options waved(std::uint64_t seed, const std::vector<oracle::Effect>& effects,
                      oracle::MotionKind kind = oracle::MotionKind::kLevel) {
  oracle::Options o;
  o.seed = seed;
  o.rate_hz = 50.0;
  o.device_kind = oracle::DeviceKind::kBoard;
  o.noise = oracle::kRealisticDensities;
  o.motion.kind = kind;
  o.motion.duration_s = 90.0;
  o.motion.fastest_rad_s = 2.0;
  o.motion.farthest_turn_deg = 25.0;
  o.effects = effects;
  return o;
}

// Squared Mahalanobis distance of the truth.
double distance(const Calibration& c, const oracle::Device& device) {
  const VectorXd e = test::error_of(c, device);
  return e.dot(MatrixXd(c.covariance.topLeftCorner(19, 19)).ldlt().solve(e));
}

const Check& tolerances(const Calibration& c) {
  const auto it = std::ranges::find(c.checks, "tolerances", &Check::name);
  EXPECT_NE(it, c.checks.end());
  return *it;
}

TEST(UnseenTolerances, a_sensor_that_stays_level_is_not_more_sure_than_its_parts) {
  const std::vector<oracle::Effect> errors = {
      oracle::make_effect("acc_scale_misalignment", {0, 0, 0, 0, 0, 0.005}),
      oracle::make_effect("acc_scale_misalignment", {.004, 0, -.005, 0, 0, .003}),
      oracle::make_effect("acc_scale_misalignment", {0, .004, 0, -.005, .003, 0})};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const oracle::Simulation s = oracle::simulate(waved(9501 + i, {errors[i]}));
    const Calibration c = calibrate(s.recording);
    EXPECT_NE(c.trust.verdict, Verdict::kNo);
    EXPECT_LT(distance(c, s.truth.device), test::kOutside) << i;
  }
}

TEST(UnseenTolerances, are_told_where_the_sensor_stays_level) {
  const Calibration c = calibrate(oracle::simulate(waved(9511, {})).recording);
  EXPECT_EQ(tolerances(c).status, CheckStatus::kCaution);
  EXPECT_NE(tolerances(c).sentence.find("To be sure, hold every face"), std::string::npos)
      << tolerances(c).sentence;
  EXPECT_GT(c.sigma("gyroscope.bias[2]"),
            10.0 * std::sqrt(c.covariance_model(5, 5) - c.covariance_common(5, 5)));
}

TEST(UnseenTolerances, leave_the_sigmas_of_a_rich_motion_alone) {
  using enum oracle::MotionKind;
  for (const oracle::MotionKind kind : {kRotation, kHandHeld}) {
    const Calibration c = calibrate(oracle::simulate(waved(9521, {}, kind)).recording);
    EXPECT_EQ(tolerances(c).status, CheckStatus::kOk) << tolerances(c).sentence;
    for (int i = 0; i < 19; ++i) {
      const double without = c.covariance_model(i, i) - c.covariance_common(i, i);
      EXPECT_LT(std::sqrt(c.covariance_model(i, i) / without), 1.03) << c.order[std::size_t(i)];
    }
  }
}

// Two recordings of one device have the same errors of its parts.
TEST(UnseenTolerances, do_not_shrink_with_an_older_calibration_of_the_same_motion) {
  oracle::Options o = waved(9531, {});
  o.device_seed = 1;
  const Calibration old = calibrate(oracle::simulate(o).recording);
  o.seed = 9532;
  const Recording next = oracle::simulate(o).recording;
  CalibrationOptions options;
  options.prior = PriorKind::kGiven;
  options.given_prior = std::make_shared<const GivenPrior>(GivenPrior{"old.json", old, 0.0, 0.0});
  const Calibration alone = calibrate(next), both = calibrate(next, options);
  EXPECT_GT(both.sigma("gyroscope.bias[2]"),
            0.95 * std::min(alone.sigma("gyroscope.bias[2]"), old.sigma("gyroscope.bias[2]")));
}

}  // namespace
}  // namespace magimu
