// SPDX-License-Identifier: BSD-3-Clause
// What is known beforehand: weighed as it should be, without effect where the recording knows
// better, and refused where the device has changed since.
#include "calibration/fit/parameter_prior.h"

#include <Eigen/Dense>
#include <algorithm>
#include <random>

#include "calibration/result/parameter_vector.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

CalibrationOptions with_prior(CalibrationOptions options, PriorKind prior) {
  options.prior = prior;
  return options;
}

// The same with an older calibration of the device, given so.
CalibrationOptions after(CalibrationOptions options, const Calibration& old, double drift,
                         double age_days = 0.0) {
  options.prior = PriorKind::kGiven;
  options.given_prior =
      std::make_shared<const GivenPrior>(GivenPrior{"old.json", old, age_days, drift});
  return options;
}

const Simulation& hand() {
  static const Simulation s = test::simulated_hand(50.0, 21, 90.0);
  return s;
}

// Moved about, and hardly turned yet: what the accelerometer reads is the hand's as much as its
// own.
Simulation hardly_turned() {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHandHeld;
  options.rate_hz = 50.0;
  options.seed = 21;
  options.duration_s = 7.0;
  return simulate(options);
}

TEST(ParameterPrior, vector_and_calibration_are_two_of_one_thing) {
  Calibration c = calibrate(hand().recording, test::same_model(hand(), 2));
  const VectorXd theta = parameter_vector(c);
  ASSERT_EQ(theta.size(), Eigen::Index(c.order.size()));
  EXPECT_EQ(theta.head(19), in_calibration_order(c));
  VectorXd moved = theta;
  moved[7] += 0.5;
  moved[18] += 1.0;
  set_parameters(c, moved);
  EXPECT_EQ(c.order[7], "magnetometers[0].distortion[1][0]");
  EXPECT_DOUBLE_EQ(c.parameters.mag[0].distortion(1, 0), moved[7]);
  EXPECT_NEAR(c.parameters.dip_rad, moved[18] * kDegree, 1e-12);
  EXPECT_TRUE(parameter_vector(c).isApprox(moved, 1e-12));
}

TEST(ParameterPrior, changes_nothing_where_the_recording_knows_better) {
  const CalibrationOptions options = test::same_model_and_noise(hand(), 1);
  const Calibration none = calibrate(hand().recording, with_prior(options, PriorKind::kNone));
  const Calibration usual = calibrate(hand().recording, with_prior(options, PriorKind::kUsual));
  EXPECT_EQ(none.prior.source, "none");
  EXPECT_EQ(usual.prior.source, "default");
  EXPECT_LT(test::sigmas_apart(none, usual), 0.05);
  EXPECT_EQ(usual.trust.verdict, none.trust.verdict);
  // Known to a hundredth of the prior: not even the sigma shows it.
  EXPECT_NEAR(usual.sigma("accelerometer.bias[0]"), none.sigma("accelerometer.bias[0]"),
              0.01 * none.sigma("accelerometer.bias[0]"));
}

TEST(ParameterPrior, helps_where_the_recording_tells_little) {
  const Simulation s = hardly_turned();
  CalibrationOptions options = test::same_model_and_noise(s, 1);
  options.motion = MotionModel::kHandHeld;
  const Recording& little = s.recording;
  const Calibration none = calibrate(little, with_prior(options, PriorKind::kNone));
  const Calibration usual = calibrate(little, with_prior(options, PriorKind::kUsual));
  const MatrixXd A = none.covariance, B = usual.covariance;
  EXPECT_LT(B(14, 14), 0.5 * A(14, 14)) << "of distortion[2][2]";
  EXPECT_LE(usual.sigma("accelerometer.bias[0]"), 0.2);
  // What the posterior claims, holds.
  const VectorXd error = parameter_error(usual, s.truth.parameters);
  const VectorXd sigma = B.diagonal().cwiseSqrt();
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    EXPECT_LT(std::abs(error[i]), 4.0 * sigma[i]) << usual.order[std::size_t(i)];
  }
}

TEST(ParameterPrior, is_as_wide_as_the_magnetometer_shows) {
  Calibration c = calibrate(hand().recording, test::same_model(hand(), 2));
  // A bare part with an axis of its own: as far from what is usual as some are.
  c.parameters.mag[0].bias = Vector3(300.0, -150.0, 80.0);
  const VectorXd before = parameter_vector(c);
  take_prior(c, usual_prior(c), 20);
  const VectorXd moved =
      (parameter_vector(c) - before).cwiseQuotient(c.covariance.diagonal().cwiseSqrt());
  EXPECT_LT(moved.cwiseAbs().maxCoeff(), 0.1);
  const auto sigma = [&](const std::string& name) {
    const auto& all = c.prior.parameters;
    return std::ranges::find(all, name, &PriorRecord::Parameter::name)->sigma;
  };
  EXPECT_GT(sigma("magnetometers[0].bias[0]"), 100.0);
  EXPECT_DOUBLE_EQ(sigma("accelerometer.bias[0]"), 0.2);
}

TEST(ParameterPrior, knows_nothing_of_how_the_magnetometer_is_mounted) {
  Calibration c = calibrate(hand().recording, test::same_model(hand(), 2));
  Matrix3 mounting;
  mounting << 0.0, -1.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0;
  const Matrix3 D = 40.0 * mounting * (Matrix3::Identity() + 0.02 * Matrix3::Ones());
  c.parameters.mag[0].distortion = D;
  const LinearPrior prior = usual_prior(c);
  const VectorXd off = prior.H * parameter_vector(c) - prior.mean;
  // Off by 2 % of each entry, of 5 % expected.
  EXPECT_LT(
      (off.array() / prior.covariance.diagonal().array().sqrt()).segment(3, 8).abs().maxCoeff(),
      1.5);
}

// White noise gives sandwiches that scatter about the model's covariance.
TEST(ParameterPrior, scatter_that_white_noise_makes_is_not_weighed) {
  const int n = 19, blocks = 60;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const MatrixXd L = MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
  const MatrixXd model = L * L.transpose();
  MatrixXd robust = MatrixXd::Zero(n, n);
  for (int b = 0; b < blocks; ++b) {
    const VectorXd score = L * VectorXd::NullaryExpr(n, [&] { return normal(random); });
    robust += score * score.transpose() / blocks;
  }
  EXPECT_LT((weighing_covariance(model, robust, blocks) - model).norm(), 1e-9 * model.norm());
  // A direction in which the residuals scatter nine times as much counts as that.
  const VectorXd u = L.col(0);
  const MatrixXd wide = weighing_covariance(model, robust + 80.0 * u * u.transpose(), blocks);
  EXPECT_NEAR(u.dot(model.ldlt().solve(MatrixXd(wide - model)) * model.ldlt().solve(u)), 80.0, 8.0);
}

// Each recording with the last result as its prior, against all of them together.
TEST(ParameterPrior, a_chain_of_recordings_is_all_of_them_together) {
  const Simulation s = test::simulated_hand(50.0, 23, 240.0);
  const CalibrationOptions options = with_prior(test::same_model_and_noise(s, 2), PriorKind::kNone);
  std::vector<Recording> pieces;
  std::vector<const Recording*> pointers;
  for (int i = 0; i < 4; ++i) pieces.push_back(slice(s.recording, 60.0 * i, 60.0 * (i + 1)));
  for (const Recording& piece : pieces) pointers.push_back(&piece);
  const Calibration all = calibrate(pointers, options);
  Calibration last = calibrate(pieces[0], options);
  for (int i = 1; i < 4; ++i) last = calibrate(pieces[std::size_t(i)], after(options, last, 0.0));
  const VectorXd apart = (parameter_vector(last).head(18) - parameter_vector(all).head(18))
                             .cwiseQuotient(all.covariance_model.diagonal().head(18).cwiseSqrt());
  // The prior is weighed at each recording's own optimum, and not linearized again.
  EXPECT_LT(apart.cwiseAbs().maxCoeff(), 0.3);
  for (Eigen::Index i = 0; i < 18; ++i) {
    // Where a check has widened a recording's sigmas, it counts for less than its noise would say.
    EXPECT_NEAR(std::sqrt(last.covariance_model(i, i) / all.covariance_model(i, i)), 1.1, 0.15)
        << all.order[std::size_t(i)];
  }
}

TEST(ParameterPrior, a_device_that_changed_is_told) {
  const Simulation& s = hand();
  const CalibrationOptions options = test::same_model(s, 2);
  const Calibration old = calibrate(s.recording, options);
  Recording now = s.recording;
  for (Vector3& m : now.mag.front().v) m += Vector3(6.0, 0.0, 0.0);
  const Calibration c = calibrate(now, after(options, old, 1.0, 1.0));
  ASSERT_FALSE(c.warnings.empty());
  EXPECT_NE(c.warnings.back().find("magnetometers[0].bias"), std::string::npos)
      << c.warnings.back();
  EXPECT_NEAR(c.parameters.mag[0].bias[0], old.parameters.mag[0].bias[0] + 6.0, 0.1);
  // The same device, another day: nothing to tell.
  const Calibration same = calibrate(s.recording, after(options, old, 1.0, 1.0));
  for (const std::string& w : same.warnings) EXPECT_EQ(w.find("old.json"), std::string::npos) << w;
}

TEST(ParameterPrior, grows_wider_with_age) {
  const Calibration old = calibrate(hand().recording, test::same_model(hand(), 2));
  const LinearPrior fresh = prior_of({"a", old, 0.0, 1.0}, old);
  const LinearPrior aged = prior_of({"a", old, 100.0, 1.0}, old);
  const LinearPrior exact = prior_of({"a", old, 100.0, 0.0}, old);
  for (Eigen::Index i = 0; i < fresh.mean.size(); ++i) {
    EXPECT_GT(aged.covariance(i, i), fresh.covariance(i, i));
    EXPECT_GT(fresh.covariance(i, i), exact.covariance(i, i));
  }
  EXPECT_EQ(fresh.mean.size(), 18);  // not the dip
}

}  // namespace
}  // namespace magimu
