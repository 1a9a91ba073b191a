// SPDX-License-Identifier: BSD-3-Clause
// Good sensors whose logger writes two decimals: rates in rad/s, accelerations in g.
#include <gmock/gmock.h>

#include "calibration/trust/trust.h"
#include "diagnosis/result/diagnosis.h"
#include "sim/simulate.h"
#include "study/error_statistics.h"

namespace magimu {
namespace {

void round_to(double step, VectorSeries& s) {
  for (Vector3& v : s.v) v = step * (v / step).array().round().matrix();
}

struct Written {
  SimulatedMotion motion;
  std::uint64_t seed;
};

class TwoDecimals : public testing::TestWithParam<Written> {
 protected:
  static Simulation written() {
    SimulationOptions options;
    options.motion = GetParam().motion;
    options.seed = GetParam().seed;
    options.rate_hz = 100.0;
    options.duration_s = 60.0;
    options.noise = {0.002, 1e-4, 0.03};
    Simulation s = simulate(options);
    round_to(0.01 * kStandardGravity, s.recording.acc);
    round_to(0.01, s.recording.gyr);
    return s;
  }
};

TEST_P(TwoDecimals, are_calibrated_within_their_sigmas) {
  const Simulation s = written();
  const Calibration c = calibrate(s.recording);
  EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
  const VectorXd error = parameter_error(c, s.truth.parameters);
  const VectorXd sigma = c.covariance.diagonal().head(error.size()).cwiseSqrt();
  EXPECT_LT(error.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 4.0);
  EXPECT_LT(sigma.segment<3>(3).maxCoeff(), 6e-4) << "rad/s";
}

TEST_P(TwoDecimals, are_no_outliers_and_no_fault) {
  const Diagnosis d = diagnose(written().recording, {});
  EXPECT_THAT(d.answer, testing::AnyOf(Answer::kPredicts, Answer::kExplained));
  for (const Finding& f : d.findings) EXPECT_EQ(f.effect, "linear_acceleration");
  EXPECT_THAT(d.notes, testing::Contains(testing::HasSubstr("gyr comes in steps of 0.01 rad/s")));
}

INSTANTIATE_TEST_SUITE_P(Motions, TwoDecimals,
                         testing::Values(Written{SimulatedMotion::kHand, 1},
                                         Written{SimulatedMotion::kHandHeld, 2},
                                         Written{SimulatedMotion::kHandHeld, 3}));

}  // namespace
}  // namespace magimu
