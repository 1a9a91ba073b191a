// SPDX-License-Identifier: BSD-3-Clause
// The rivals on simulated recordings, against the truth and against the MAP.
#include "calibration/rivals/rival_calibration.h"

#include <gtest/gtest.h>

#include "recording/data/error.h"
#include "sim/simulate.h"
#include "study/error_statistics.h"
#include "study/rotation_model.h"

namespace magimu {
namespace {

Simulation rival_simulation(std::uint64_t seed, int mag_ratio = 1) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 20.0;
  options.mag_ratio = mag_ratio;
  options.seed = seed;
  return simulate(options);
}

CalibrationOptions rival_given(const Simulation& s) {
  return rotation_model(s.truth.noise, s.truth.gravity);
}

// The largest departure of a parameter, in the MAP's standard deviations.
double rival_from_map(const Calibration& c, const Calibration& map) {
  const VectorXd e = parameter_error(c, map.parameters);
  return e.cwiseQuotient(map.covariance_model.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff();
}

TEST(Rivals, sound_forms_end_at_the_map_with_its_covariance) {
  for (const int ratio : {1, 4}) {
    const Simulation s = rival_simulation(3, ratio);
    const Calibration map = calibrate(s.recording, rival_given(s));
    for (const RivalMethod method : {RivalMethod::kKok, RivalMethod::kWu}) {
      const RivalCalibration r = calibrate_by({.method = method}, {&s.recording}, rival_given(s));
      const Calibration& c = r.calibration;
      EXPECT_EQ(r.method, to_string(method));
      EXPECT_FALSE(r.not_estimated.empty());
      EXPECT_TRUE(c.fit.converged()) << c.fit.message;
      EXPECT_EQ(c.trust.verdict, Verdict::kYes) << r.method << ": " << c.trust.reasons.front();
      EXPECT_EQ(c.order, map.order);
      EXPECT_LE(c.fit.iterations, 8);
      // A magnetometer slower than the IMU: the MAP's nodes are its samples, with means between.
      EXPECT_LT(rival_from_map(c, map), ratio == 1 ? 0.1 : 0.5) << r.method;
      const VectorXd sigmas = c.covariance_model.diagonal().cwiseSqrt().cwiseQuotient(
          map.covariance_model.diagonal().cwiseSqrt());
      EXPECT_GT(sigmas.minCoeff(), 0.95) << r.method;
      EXPECT_LT(sigmas.maxCoeff(), 1.05) << r.method;
    }
  }
}

// Of the seeds 1 to 100 those where the objective rises on the last hundredths of a standard
// deviation.
TEST(Rivals, kok_ends_in_few_iterations_where_the_scores_vanish_beside_the_objectives_minimum) {
  for (const std::uint64_t seed : {12u, 61u, 87u}) {
    SimulationOptions options;
    options.rate_hz = 10.0;
    options.seed = seed;
    const Simulation s = simulate(options);
    const Calibration c =
        calibrate_by({.method = RivalMethod::kKok}, {&s.recording}, rival_given(s)).calibration;
    EXPECT_TRUE(c.fit.converged()) << c.fit.message;
    EXPECT_LE(c.fit.iterations, 8) << seed;
  }
}

TEST(Rivals, published_kok_is_stopped_by_its_limit_before_the_optimum) {
  SimulationOptions options;
  options.rate_hz = 10.0;
  const Simulation s = simulate(options);
  CalibrationOptions given = rival_given(s);
  given.initialization.gyr_bias = Vector3::Constant(0.01);
  const RivalCalibration r =
      calibrate_by({.method = RivalMethod::kKok, .as_published = true, .start_at_identity = true},
                   {&s.recording}, given);
  EXPECT_EQ(r.calibration.fit.reason, StopReason::kMaxIterations) << r.calibration.fit.message;
  EXPECT_GE(r.filter_runs, 1900);
  EXPECT_EQ(r.calibration.trust.verdict, Verdict::kNo);
  const RivalCalibration sound = calibrate_by({}, {&s.recording}, rival_given(s));
  EXPECT_GT(rival_from_map(r.calibration, sound.calibration), 1.0);
}

TEST(Rivals, published_wu_needs_one_recording_and_says_so) {
  const Simulation s = rival_simulation(1);
  const RivalOptions wu{.method = RivalMethod::kWu, .as_published = true};
  EXPECT_THROW(calibrate_by(wu, {&s.recording, &s.recording}, rival_given(s)), InputError);
  const RivalCalibration r = calibrate_by(wu, {&s.recording}, rival_given(s));
  const double error =
      (r.calibration.parameters.mag[0].distortion - s.truth.parameters.mag[0].distortion).norm();
  EXPECT_LT(error, 1.0);  // published RMSE: 0.14 to 0.29 uT
}

TEST(Rivals, several_recordings_share_the_parameters_and_have_a_dip_each) {
  const Simulation a = rival_simulation(1);
  const Recording first = slice(a.recording, 0.0, 60.0), second = slice(a.recording, 60.0, 117.0);
  for (const RivalMethod method : {RivalMethod::kKok, RivalMethod::kWu}) {
    const Calibration c =
        calibrate_by({.method = method}, {&first, &second}, rival_given(a)).calibration;
    ASSERT_EQ(c.fields.size(), 2u);
    EXPECT_EQ(c.order.size(), 20u);
    for (const FieldEstimate& f : c.fields) {
      EXPECT_NEAR(f.dip_rad, a.truth.parameters.dip_rad, 5.0 * f.dip_sigma_rad);
    }
  }
}

}  // namespace
}  // namespace magimu
