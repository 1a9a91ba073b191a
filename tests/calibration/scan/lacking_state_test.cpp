// SPDX-License-Identifier: BSD-3-Clause
// A disturbance that no catalogue has widens the sigmas so that they cover what it does.
#include "calibration/scan/lacking_state.h"

#include <algorithm>
#include <cmath>

#include "tests/calibration/cases.h"

namespace magimu {
namespace {

const Check& model_check_of(const Calibration& c) {
  return *std::ranges::find(c.checks, "model", &Check::name);
}

// A device beside the magnetometer that draws current for two of every four seconds.
Simulation with_switched_current(double uT) {
  Simulation s = test::simulated_hand(50.0, 41, 90.0);
  VectorSeries& mag = s.recording.mag.front();
  for (std::size_t k = 0; k < mag.size(); ++k) {
    if (std::fmod(mag.t[k], 4.1) < 2.0) mag.v[k] += Vector3(uT, 0.5 * uT, -0.3 * uT);
  }
  return s;
}

TEST(LackingState, covers_what_it_does_to_the_bias) {
  const Simulation s = with_switched_current(1.0);
  const Calibration c = calibrate(s.recording, test::same_model(s, 2));
  const Vector3 error = c.parameters.mag[0].bias - s.truth.parameters.mag[0].bias;
  EXPECT_GT(error.norm(), 0.3) << "it must do harm";
  for (int i = 0; i < 3; ++i) {
    const double sigma = c.sigma("magnetometers[0].bias[" + std::to_string(i) + "]");
    EXPECT_LT(std::abs(error[i]), 3.0 * sigma) << i;
  }
  EXPECT_NE(model_check_of(c).status, CheckStatus::kOk);
  EXPECT_NE(model_check_of(c).sentence.find("missing in the model"), std::string::npos)
      << model_check_of(c).sentence;
}

TEST(LackingState, is_not_seen_where_nothing_is_missing) {
  for (const std::uint64_t seed : {41, 42, 43}) {
    const Simulation s = test::simulated_hand(50.0, seed, 90.0);
    const Calibration c = calibrate(s.recording, test::same_model(s, 2));
    EXPECT_EQ(model_check_of(c).status, CheckStatus::kOk) << model_check_of(c).sentence;
  }
}

}  // namespace
}  // namespace magimu
