// SPDX-License-Identifier: BSD-3-Clause
// Recordings of one device: shared parameters, a dip each.
#include <Eigen/LU>

#include "recording/data/error.h"
#include "tests/calibration/cases.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using test::same_model_and_noise;

// One recording cut in two: the same device in the same field.
struct Halves {
  Simulation s = test::simulated_hand(50.0, 11);
  Recording first = slice(s.recording, 0.0, 60.0);
  Recording second = slice(s.recording, 60.0, 1e9);
};

// Information about the shared 18 parameters, the dips integrated out.
MatrixXd shared_information(const Calibration& c) {
  return c.covariance_model.topLeftCorner(18, 18).inverse();
}

TEST(SeveralRecordings, share_the_parameters_and_have_a_dip_each) {
  const Halves h;
  const Calibration c = calibrate({&h.first, &h.second}, same_model_and_noise(h.s, 2));
  ASSERT_EQ(c.fields.size(), 2U);
  ASSERT_EQ(c.trajectories.size(), 2U);
  EXPECT_EQ(c.order.size(), 20U);
  EXPECT_EQ(c.order.back(), "fields[1].dip_deg");
  test::expect_consistent(c, h.s.truth.parameters);
}

TEST(SeveralRecordings, their_information_adds) {
  const Halves h;
  const CalibrationOptions options = same_model_and_noise(h.s, 2);
  const Calibration both = calibrate({&h.first, &h.second}, options);
  const Calibration a = calibrate(h.first, options), b = calibrate(h.second, options);
  const MatrixXd P = (shared_information(a) + shared_information(b)).inverse();
  for (Eigen::Index i = 0; i < 18; ++i) {
    const double sigma = std::sqrt(both.covariance_model(i, i));
    EXPECT_NEAR(sigma, std::sqrt(P(i, i)), 0.02 * sigma) << both.order[std::size_t(i)];
  }
  // And so do their estimates, weighted by it.
  const VectorXd mean = P * (shared_information(a) * in_calibration_order(a).head(18) +
                             shared_information(b) * in_calibration_order(b).head(18));
  const VectorXd apart =
      (in_calibration_order(both).head(18) - mean).cwiseQuotient(P.diagonal().cwiseSqrt());
  EXPECT_LT(apart.cwiseAbs().maxCoeff(), 0.1);
}

TEST(SeveralRecordings, their_order_matters_to_nothing) {
  const Halves h;
  const CalibrationOptions options = same_model_and_noise(h.s, 2);
  const Calibration ab = calibrate({&h.first, &h.second}, options);
  const Calibration ba = calibrate({&h.second, &h.first}, options);
  const VectorXd apart = (in_calibration_order(ab) - in_calibration_order(ba))
                             .head(18)
                             .cwiseQuotient(ab.covariance_model.diagonal().head(18).cwiseSqrt());
  EXPECT_LT(apart.cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_NEAR(ab.fields[0].dip_rad, ba.fields[1].dip_rad, 1e-3 * ab.fields[0].dip_sigma_model_rad);
}

TEST(SeveralRecordings, of_different_devices_are_refused) {
  const Simulation one = test::simulated_hand(50.0, 1, 20.0);
  const Simulation array = test::simulated_hand(50.0, 1, 20.0, 1, 2);
  const InputError error = test::error_of([&] {
    calibrate({&one.recording, &array.recording}, {});
  });
  EXPECT_NE(error.problem.find("2 magnetometers"), std::string::npos) << error.what();
  EXPECT_FALSE(error.remedy.empty());
}

}  // namespace
}  // namespace magimu
