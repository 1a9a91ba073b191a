// SPDX-License-Identifier: BSD-3-Clause
// Samples that no measurement can have given cost a calibration nothing but themselves, and are
// told.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "calibration/result/calibration_json.h"
#include "calibration/survey/survey.h"
#include "recording/data/error.h"
#include "tests/calibration/cases.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Simulation minute(SimulatedMotion motion) {
  SimulationOptions options;
  options.motion = motion;
  options.rate_hz = 50.0;
  options.duration_s = 60.0;
  options.seed = 3;
  return simulate(options);
}

void spoil(Recording& r) {
  r.acc.v[900][0] = 98000.0;
  r.acc.v[1800] = Vector3(1e16, 0.0, 0.0);
  r.gyr.v[1500][2] = NAN;
  r.gyr.v[1000] = Vector3(-3276.8, 120.0, 999.0);
  r.mag[0].v[2000][1] = 4900.0;
  r.mag[0].v[700].setZero();
}

// The magnetometer's samples of some times alone.
Recording measured_where(const Recording& given, const std::function<bool(double t)>& measured) {
  Recording out = given;
  VectorSeries kept;
  const VectorSeries& mag = given.mag[0];
  for (std::size_t k = 0; k < mag.size(); ++k) {
    if (measured(mag.t[k])) kept.push_back(mag.t[k], mag.v[k]);
  }
  out.mag[0] = std::move(kept);
  return out;
}

// Blocks of five seconds are left out in turn and predicted by the others: here every other one has
// no magnetometer.
TEST(SetAside, a_magnetometer_that_measures_every_other_five_seconds_calibrates) {
  const Simulation s = minute(SimulatedMotion::kHand);
  const Calibration c =
      calibrate(measured_where(s.recording, [](double t) { return std::fmod(t, 10.0) < 5.0; }));
  EXPECT_NE(c.trust.verdict, Verdict::kNo) << testing::PrintToString(c.trust.reasons);
  const auto predicted = std::ranges::find(c.checks, "cross_validation", &Check::name);
  ASSERT_NE(predicted, c.checks.end());
  EXPECT_EQ(predicted->status, CheckStatus::kOk) << predicted->sentence;
  const Vector3 sigma = c.covariance.diagonal().segment<3>(15).cwiseSqrt();
  const Vector3 off = c.parameters.mag[0].bias - s.truth.parameters.mag[0].bias;
  EXPECT_LT(off.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 4.0);
}

// Too little for anything: a verdict, and no failure of what looks at it.
TEST(SetAside, a_magnetometer_that_measures_a_moment_is_no_calibration) {
  const Simulation s = minute(SimulatedMotion::kHand);
  for (const double after : {58.5, 1e9}) {  // at the end, too, or not
    const Calibration c =
        calibrate(measured_where(s.recording, [&](double t) { return t < 4.5 || t > after; }));
    EXPECT_EQ(c.trust.verdict, Verdict::kNo) << after;
    EXPECT_FALSE(c.trust.reasons.empty()) << after;
  }
}

TEST(SetAside, impossible_samples_do_not_move_a_calibration) {
  for (const SimulatedMotion motion : {SimulatedMotion::kHand, SimulatedMotion::kHandHeld}) {
    const Simulation s = minute(motion);
    Recording spoilt = s.recording;
    spoil(spoilt);
    CalibrationOptions options;
    options.gravity = s.truth.gravity;
    const Calibration clean = calibrate(s.recording, options), c = calibrate(spoilt, options);
    EXPECT_EQ(c.trust.verdict, clean.trust.verdict) << testing::PrintToString(c.trust.reasons);
    EXPECT_EQ(c.motion, clean.motion);
    ASSERT_EQ(c.effects.size(), clean.effects.size());
    EXPECT_LT(test::sigmas_apart(clean, c), 0.5);
    EXPECT_TRUE(clean.set_aside.empty());
    std::size_t count = 0;
    for (const SetAsideOf& of : c.set_aside) count += of.what.count;
    ASSERT_EQ(count, 6u);
    EXPECT_EQ(c.set_aside[0].what.sensor, "acc");
    EXPECT_EQ(c.set_aside[0].recording, spoilt.name);
    const nlohmann::ordered_json json = to_json(c);
    ASSERT_EQ(json["set_aside"].size(), c.set_aside.size());
    const auto spike = std::ranges::find_if(json["set_aside"], [](const auto& entry) {
      return entry["kind"] == "spike" && entry["sensor"] == "mag";
    });
    ASSERT_NE(spike, json["set_aside"].end());
    EXPECT_EQ((*spike)["count"], 1);
    EXPECT_THAT(std::string((*spike)["example"]), HasSubstr("mag_y = 4900 uT at 40.00 s"));
    EXPECT_THAT(c.warnings, testing::Contains(HasSubstr("acc_x = 98000 m/s^2 at 18.00 s")));
  }
}

TEST(SetAside, many_of_a_sensor_lower_the_verdict_and_most_of_it_are_refused) {
  Recording some = minute(SimulatedMotion::kHand).recording, most = some;
  for (std::size_t k = 0; k < some.mag[0].size(); ++k) {
    if (k % 40 == 7) some.mag[0].v[k][2] = -375.6;
    if (k % 3 != 0) most.mag[0].v[k][2] = NAN;
  }
  const Calibration c = calibrate(some);
  EXPECT_EQ(c.trust.verdict, Verdict::kLimited);
  EXPECT_THAT(c.trust.reasons,
              ElementsAre(HasSubstr("mag: 75 of 3000 samples (2.5 %) are set aside")));
  const InputError error = test::error_of([&] { calibrate(most); });
  EXPECT_THAT(error.what(), HasSubstr("67 % of the samples of mag are no measurements"));
  EXPECT_THAT(survey(most).not_looked_further, HasSubstr("67 % of the samples of mag"));
  EXPECT_TRUE(survey(some).usable());
}

}  // namespace
}  // namespace magimu
