// SPDX-License-Identifier: BSD-3-Clause
// Gyroscopes whose samples are the mean rate of the interval before their time: everything else
// then seems to be early by a sample. What a hand's motion hides goes into the accelerometer's
// bias.
#include "calibration/beginning.h"

#include "tests/calibration/cases.h"

namespace magimu {
namespace {

Simulation waved(std::uint64_t seed) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHandHeld;
  options.rate_hz = 100.0;
  options.duration_s = 60.0;
  options.seed = seed;
  options.gravity = CalibrationOptions().gravity;
  return simulate(options);
}

TEST(Beginning, puts_the_accelerometer_s_samples_where_they_belong) {
  for (const std::uint64_t seed : {9301U, 9302U, 9303U}) {
    SCOPED_TRACE(seed);
    Simulation s = waved(seed);
    constexpr double kEarly = 0.01;
    for (double& t : s.recording.gyr.t) t += kEarly;
    const Calibration c = calibrate(s.recording);
    EXPECT_NE(c.trust.verdict, Verdict::kNo);
    double lag = 0.0, sigma = 0.0;
    for (const ActiveEffect& effect : c.effects) {
      if (effect.name != "acc_time_offset") continue;
      lag = effect.parameters.front().value;
      sigma = effect.parameters.front().sigma_model;
    }
    EXPECT_GT(sigma, 0.0);
    EXPECT_LT(sigma, 0.3 * kEarly);
    EXPECT_NEAR(lag, -kEarly, 4.0 * sigma);
    const VectorXd error = parameter_error(c, s.truth.parameters);
    const MatrixXd V = c.covariance.topLeftCorner(error.size(), error.size());
    const VectorXd scale = V.diagonal().cwiseSqrt();
    const VectorXd z = error.cwiseQuotient(scale);
    const MatrixXd C = scale.cwiseInverse().asDiagonal() * V * scale.cwiseInverse().asDiagonal();
    EXPECT_LT(z.dot(C.ldlt().solve(z)), 43.8);  // 99.9 % of 19
  }
}

}  // namespace
}  // namespace magimu
