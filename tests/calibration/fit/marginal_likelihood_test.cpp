// SPDX-License-Identifier: BSD-3-Clause
// The marginal likelihood of a stage against its definition in dense matrices.
#include "calibration/fit/marginal_likelihood.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "calibration/pipeline.h"
#include "tests/calibration/cases.h"
#include "tests/graph/dense.h"

namespace magimu {
namespace {

// The integral of exp(-r' r / 2) over all unknowns, its logarithm up to a constant: minus half the
// squared residuals, minus half log det J' J. What whitening adds is the test's to say.
double dense_integral(const Stage& stage) {
  const Values& values = stage.result().values;
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const MatrixXd J = test::dense_jacobian(system);
  const VectorXd scale = J.colwise().norm().cwiseInverse();
  const Eigen::LDLT<MatrixXd> ldlt(
      MatrixXd(scale.asDiagonal() * (J.transpose() * J) * scale.asDiagonal()));
  return -0.5 * system.residual().squaredNorm() -
         0.5 * (ldlt.vectorD().array().log().sum() - 2.0 * scale.array().log().sum());
}

TEST(MarginalLikelihood, is_the_integral_over_trajectory_and_parameters) {
  const Simulation s = test::simulated_hand(20.0, 1, 40.0);
  const std::vector<const Recording*> recordings = {&s.recording};
  CalibrationOptions options = test::same_model_and_noise(s, 4);
  const Pipeline pipeline(recordings, options);
  const Stage a = pipeline.coarse_fit(MotionModel::kRotation);
  ModelSpec twice = a.spec();
  twice.noise.acc *= 2.0;
  const Stage b = pipeline.refit_with_same_noise(a, twice);
  ASSERT_TRUE(a.result().converged() && b.result().converged());
  // Three rows a node of the accelerometer, each with half the weight.
  const double weights = -3.0 * double(a.plans().front().t.size()) * std::log(2.0);
  EXPECT_NEAR(log_marginal_likelihood(b) - log_marginal_likelihood(a),
              dense_integral(b) - dense_integral(a) + weights, 1e-4);
  EXPECT_GT(log_marginal_likelihood(a), log_marginal_likelihood(b));  // the truth is likelier
}

}  // namespace
}  // namespace magimu
