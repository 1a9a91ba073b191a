// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/stream_checks.h"

#include <gmock/gmock.h>

#include "bench/streamed.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// An estimate whose standard deviations are all sigma.
Calibration estimate_with(double sigma, const Vector3& gyr_bias) {
  Calibration c;
  c.parameters.gyr_bias = gyr_bias;
  c.parameters.mag.resize(1);
  c.fields.resize(1);
  c.covariance = sigma * sigma * MatrixXd::Identity(19, 19);
  return c;
}

std::vector<CheckStatus> statuses(const StreamChecks& checks) {
  std::vector<CheckStatus> out;
  for (const Check& c : checks.checks()) out.push_back(c.status);
  return out;
}

constexpr CheckStatus kFine = CheckStatus::kOk, kDoubtful = CheckStatus::kCaution;
const WindowFit kFits{.nis = 60.0, .dof = 60};

TEST(StreamChecks, are_silent_until_there_is_something_to_compare) {
  StreamChecks checks;
  EXPECT_TRUE(checks.checks().empty());
  for (const double t : {1.0, 2.0, 3.0}) {
    checks.add(t, estimate_with(1.0, Vector3::Zero()), 2.0, kFits);
    EXPECT_TRUE(checks.checks().empty());
  }
  checks.add(4.0, estimate_with(0.9, Vector3::Zero()), 1.8, kFits);
  EXPECT_THAT(statuses(checks), ElementsAre(kFine, kFine, kFine));
  checks.forget();
  EXPECT_TRUE(checks.checks().empty());
}

// From a variance of 1 to one of 0.64: changes scatter by 0.6.
TEST(StreamChecks, changes_are_judged_by_what_new_samples_explain) {
  for (const double moved : {1.2, 4.0}) {
    StreamChecks checks;
    checks.add(0.0, estimate_with(1.0, Vector3::Zero()), 2.0, kFits);
    checks.add(5.0, estimate_with(0.8, Vector3(0.0, moved, 0.0)), 1.6, kFits);
    const Check stability = checks.checks().back();
    EXPECT_EQ(stability.name, "stability");
    EXPECT_NEAR(stability.value, moved / std::hypot(0.6, 0.08), 1e-9);
    EXPECT_EQ(stability.status, moved < 2.0 ? kFine : kDoubtful);
    EXPECT_EQ(stability.sentence.find("gyroscope bias") != std::string::npos, moved > 2.0);
  }
}

TEST(StreamChecks, an_uncertainty_that_stays_is_a_caution_until_the_target_is_reached) {
  for (const double distance : {1.5, 0.9}) {
    StreamChecks checks;
    checks.add(0.0, estimate_with(1.0, Vector3::Zero()), distance, kFits);
    checks.add(5.0, estimate_with(1.0, Vector3::Zero()), distance, kFits);
    const Check trend = checks.checks().front();
    EXPECT_EQ(trend.name, "trend");
    EXPECT_EQ(trend.status, distance > 1.0 ? kDoubtful : kFine);
  }
}

TEST(StreamChecks, seconds_are_those_of_samples_whatever_the_clock) {
  for (const double set_to : {1.79e9, -50.0}) {
    StreamChecks checks;
    checks.add(0.0, estimate_with(1.0, Vector3::Zero()), 2.0, kFits);
    checks.add(3.0, estimate_with(0.9, Vector3::Zero()), 1.8, kFits);
    checks.add(set_to, estimate_with(0.8, Vector3::Zero()), 1.6, kFits);
    checks.add(set_to + 2.0, estimate_with(0.7, Vector3::Zero()), 1.4, kFits);
    EXPECT_THAT(checks.checks().front().sentence, HasSubstr("In 5 s")) << set_to;
  }
}

TEST(StreamChecks, windows_that_do_not_fit_are_counted) {
  StreamChecks checks;
  checks.add(0.0, estimate_with(1.0, Vector3::Zero()), 2.0, kFits);
  for (const double t : {1.0, 2.0, 3.0}) {
    checks.add(t, estimate_with(0.9, Vector3::Zero()), 1.0,
               {.nis = 900.0, .dof = 60, .p_value = 0.0, .used = t < 1.5});
  }
  const Check windows = checks.checks()[1];
  EXPECT_EQ(windows.name, "windows");
  EXPECT_EQ(windows.status, kDoubtful);
  EXPECT_THAT(windows.sentence, HasSubstr("1 of the last 3 windows fit"));
}

// The newest ten seconds, of a stream from beginning to end; a gyroscope bias that jumps.
TEST(StreamChecks, a_stream_in_order_has_few_cautions_and_a_jump_of_a_bias_is_one) {
  const Simulation s = test::simulated_hand(50.0, 2, 100.0);
  Recording jumping = s.recording;
  for (std::size_t k = 0; k < jumping.gyr.size(); ++k) {
    if (jumping.gyr.t[k] > 70.0) jumping.gyr.v[k] += Vector3(0.0, 0.01, 0.0);
  }
  for (const Recording* r : std::vector<const Recording*>{&s.recording, &jumping}) {
    StreamingOptions options;
    options.gravity = s.truth.gravity;
    options.motion = MotionModel::kRotation;
    options.noise = s.truth.noise;
    StreamingCalibration stream(1, options);
    int checked = 0, doubtful = 0;
    bool bias_named = false;
    for (const StreamSample& sample : samples_of(*r)) {
      const auto u = stream.add(sample);
      if (!u) continue;
      for (const Check& check : u->checks) {
        if (check.name != "stability") continue;
        ++checked;
        if (check.status == kFine) continue;
        ++doubtful;
        bias_named |= u->t > 70.0 && check.sentence.find("gyroscope bias") != std::string::npos;
      }
    }
    EXPECT_GT(checked, 60);
    EXPECT_LE(doubtful, r == &s.recording ? checked / 20 : checked);
    EXPECT_EQ(bias_named, r != &s.recording);
  }
}

}  // namespace
}  // namespace magimu
