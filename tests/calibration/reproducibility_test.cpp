// SPDX-License-Identifier: BSD-3-Clause
// The same numbers, however they are computed.
#include <tbb/global_control.h>

#include "solvers/back_ends.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

Calibration with_threads(std::size_t threads, const Recording& recording,
                         const CalibrationOptions& options) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return calibrate(recording, options);
}

TEST(Threads, one_and_two_give_the_same_bits) {
  const Simulation s = test::simulated_hand(50.0, 31, 60.0);
  for (const MotionModel motion : {MotionModel::kRotation, MotionModel::kAuto}) {
    CalibrationOptions options = test::same_model(s);
    options.motion = motion;
    const Calibration one = with_threads(1, s.recording, options);
    const Calibration two = with_threads(2, s.recording, options);
    EXPECT_EQ(in_calibration_order(one), in_calibration_order(two));
    EXPECT_EQ(one.covariance, two.covariance);
    EXPECT_EQ(one.covariance_model, two.covariance_model);
    EXPECT_EQ(one.noise.acc, two.noise.acc);
    EXPECT_EQ(one.noise.gyr, two.noise.gyr);
    EXPECT_EQ(one.noise.mag, two.noise.mag);
    EXPECT_EQ(one.fit.iterations, two.fit.iterations);
    ASSERT_EQ(one.nodes, two.nodes);
    for (std::size_t k = 0; k < one.trajectories[0].nRb.size(); ++k) {
      ASSERT_EQ(one.trajectories[0].nRb[k].quaternion(), two.trajectories[0].nRb[k].quaternion());
    }
  }
}

TEST(BackEnds, give_the_same_calibration) {
  const Simulation s = test::simulated_hand(50.0, 32, 60.0);
  CalibrationOptions options = test::same_model_and_noise(s, 2);
  options.optimizer.backend = Backend::kEigen;
  const Calibration eigen = calibrate(s.recording, options);
  for (const Backend backend :
       {Backend::kAuto, Backend::kChain, Backend::kCholmod, Backend::kSpqr}) {
    options.optimizer.backend = backend;
    try {
      make_linear_solver(backend);
    } catch (const std::invalid_argument&) {
      continue;  // not built in
    }
    const Calibration c = calibrate(s.recording, options);
    EXPECT_LT(test::sigmas_apart(eigen, c), 1e-6) << to_string(backend);
    const VectorXd ratio =
        c.covariance_model.diagonal().cwiseQuotient(eigen.covariance_model.diagonal());
    EXPECT_LT((ratio.array() - 1.0).abs().maxCoeff(), 1e-6) << to_string(backend);
  }
}

}  // namespace
}  // namespace magimu
