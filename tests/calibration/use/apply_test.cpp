// SPDX-License-Identifier: BSD-3-Clause
// A calibration that is the truth of a simulation gives back what the sensors experienced.
#include "calibration/use/apply.h"

#include <gmock/gmock.h>

#include "calibration/use/export.h"
#include "recording/csv/csv.h"
#include "sim/simulate.h"
#include "tests/calibration/cases.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::HasSubstr;

Simulation exact(const std::vector<std::string>& effects, int magnetometers = 1,
                 int mag_ratio = 1) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 100.0;
  options.duration_s = 30.0;
  options.noise_factor = 0.0;
  options.magnetometers = magnetometers;
  options.mag_ratio = mag_ratio;
  for (const std::string& text : effects) options.effects.push_back(parse_effect_request(text));
  return simulate(options);
}

Calibration truth_of(const Simulation& s) {
  Calibration c;
  c.parameters = s.truth.parameters;
  c.mag_names = s.recording.mag_names;
  c.strength_uT = s.truth.strength_uT;
  c.gravity = s.truth.gravity;
  for (const HiddenEffect& hidden : s.truth.effects) {
    ActiveEffect effect{hidden.name, {}};
    for (const auto& p : hidden.parameters) {
      effect.parameters.push_back({"effects." + hidden.name + "." + p.name, p.unit, p.value});
    }
    c.effects.push_back(effect);
  }
  return c;
}

double largest_difference(const VectorSeries& a, const VectorSeries& b) {
  double worst = a.size() == b.size() ? 0.0 : INFINITY;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    worst = std::max(worst, (a.v[k] - b.v[k]).norm());
  }
  return worst;
}

TEST(Apply, refuses_another_unit_and_doubts_another_device) {
  const Simulation s = test::simulated_hand(50.0, 3, 60.0);
  const Calibration c = calibrate(s.recording, test::same_model(s));
  EXPECT_TRUE(apply(c, s.recording).doubts.empty());
  Recording other = s.recording;
  for (Vector3& v : other.mag.front().v) v *= 10.0;
  EXPECT_THAT(test::error_of([&] { apply(c, other); }).remedy, HasSubstr("--unit mag="));
  other = s.recording;
  for (Vector3& v : other.mag.front().v) v *= 1.5;
  EXPECT_EQ(apply(c, other).doubts.size(), 1U);
  other = s.recording;
  for (Vector3& v : other.mag.front().v) v.x() += 0.4 * c.strength_uT;
  EXPECT_EQ(apply(c, other).doubts.size(), 1U);
}

TEST(Apply, gives_the_force_and_the_field_in_the_axes_of_the_imu) {
  const Simulation s = exact({}, 2);
  const Applied applied = apply(truth_of(s), s.recording);
  const Vector3 field = s.truth.strength_uT * unit_field(s.truth.parameters.dip_rad);
  for (std::size_t k = 0; k < s.truth.t.size(); k += 37) {
    const Vector3 down = s.truth.nRb[k].unrotate(gravity_n(s.truth.gravity));
    EXPECT_LT((applied.recording.acc.v[k] + down).norm(), 1e-9);
    for (const VectorSeries& mag : applied.recording.mag) {
      EXPECT_LT((mag.v[k] - s.truth.nRb[k].unrotate(field)).norm(), 1e-9);
    }
    if (k + 1 >= s.truth.t.size()) continue;
    const double h = s.truth.t[k + 1] - s.truth.t[k];
    const Rot3 turn = Rot3::Exp(Vector3(applied.recording.gyr.v[k] * h));
    const Rot3 truth = s.truth.nRb[k].inverse() * s.truth.nRb[k + 1];
    EXPECT_LT((turn.matrix() - truth.matrix()).norm(), 1e-5);
  }
}

class AppliedEffect : public testing::TestWithParam<const char*> {};

TEST_P(AppliedEffect, is_taken_out_exactly) {
  const Simulation with = exact({GetParam()}), without = exact({});
  Recording recording = with.recording;
  ASSERT_GT(largest_difference(recording.acc, without.recording.acc) +
                largest_difference(recording.gyr, without.recording.gyr) +
                largest_difference(recording.mag[0], without.recording.mag[0]),
            1e-4)
      << "the effect must be there to be taken out";
  const Applied applied = apply(truth_of(with), recording);
  const Applied plain = apply(truth_of(without), without.recording);
  EXPECT_TRUE(applied.not_applied.empty());
  EXPECT_LT(largest_difference(applied.recording.acc, plain.recording.acc), 1e-9);
  // The simulation's mean rate of a sample is not quite what turned the sensor within it.
  EXPECT_LT(largest_difference(applied.recording.gyr, plain.recording.gyr), 2e-6);
  EXPECT_LT(largest_difference(applied.recording.mag[0], plain.recording.mag[0]), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Effects, AppliedEffect,
                         testing::Values("acc_scale_misalignment=2", "gyro_scale_misalignment=2",
                                         "gyro_nonlinearity", "mag_nonlinearity=2"));

// These need another sensor's reading at the sample's time, which is interpolated.
class NearlyAppliedEffect : public testing::TestWithParam<const char*> {};

TEST_P(NearlyAppliedEffect, is_taken_out_but_for_the_interpolation) {
  const Simulation with = exact({GetParam()}), without = exact({});
  const Applied applied = apply(truth_of(with), with.recording);
  const Applied plain = apply(truth_of(without), without.recording);
  const double gyr = largest_difference(with.recording.gyr, without.recording.gyr);
  const double mag = largest_difference(with.recording.mag[0], without.recording.mag[0]);
  ASSERT_GT(gyr + mag, 1e-3);
  EXPECT_LE(largest_difference(applied.recording.gyr, plain.recording.gyr), 0.02 * gyr);
  EXPECT_LE(largest_difference(applied.recording.mag[0], plain.recording.mag[0]), 0.02 * mag);
}

INSTANTIATE_TEST_SUITE_P(Effects, NearlyAppliedEffect,
                         testing::Values("gyro_g_sensitivity=3", "mag_eddy_current=3",
                                         "mag_current=3"));

TEST(Apply, takes_a_lag_out_by_the_magnetometers_times) {
  const Simulation s = exact({"mag_time_offset=0.0125:"}, 1, 4);
  const Applied applied = apply(truth_of(s), s.recording);
  ASSERT_EQ(applied.recording.mag[0].size(), s.recording.mag[0].size());
  for (std::size_t k = 0; k < applied.recording.mag[0].size(); ++k) {
    EXPECT_NEAR(applied.recording.mag[0].t[k], s.recording.mag[0].t[k] - 0.0125, 1e-9);
  }
  const Applied kept = apply(truth_of(s), s.recording, {.move_mag_times = false});
  EXPECT_EQ(kept.recording.mag[0].t, s.recording.mag[0].t);
  EXPECT_THAT(kept.not_applied, testing::ElementsAre(HasSubstr("lags by 0.0125 s")));
}

TEST(Apply, leaves_a_slower_magnetometer_its_empty_fields) {
  const Simulation s = exact({}, 1, 4);
  const std::string csv = csv_text(apply(truth_of(s), s.recording).recording);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + std::ptrdiff_t(s.recording.acc.size()));
  EXPECT_THAT(csv, HasSubstr(",,,\n"));
}

TEST(Apply, says_what_it_leaves_and_why) {
  Calibration c = truth_of(exact({}));
  c.effects.push_back({"hard_iron_change", {}});
  c.effects.push_back({"mag_temperature", {}});
  c.effects.push_back({"mag_lag", {}});
  const Applied applied = apply(c, exact({}).recording);
  EXPECT_THAT(applied.not_applied,
              testing::ElementsAre(HasSubstr("hard_iron_change: it belongs to the recording"),
                                   HasSubstr("mean temperature"), HasSubstr("derivative")));
}

TEST(Apply, prints_the_formula_with_its_numbers) {
  Calibration c = truth_of(exact({}));
  c.parameters.acc_bias = Vector3(0.5, 0.25, -0.125);
  const Applied applied = apply(c, exact({}).recording);
  ASSERT_EQ(applied.formulas.size(), 3u);
  EXPECT_THAT(applied.formulas[0], HasSubstr("acc - o_a, m/s^2\n  o_a = [0.5, 0.25, -0.125]"));
  EXPECT_THAT(applied.formulas[2], HasSubstr("mag_cal = s D^-1 (mag - o_m), uT"));
}

TEST(Apply, an_empty_calibration_is_refused) {
  EXPECT_THAT(test::error_of([] { apply(Calibration(), exact({}).recording); }).what(),
              HasSubstr("it is empty"));
  EXPECT_THAT(test::error_of([] { export_calibration(Calibration(), ExportTarget::kPx4); }).what(),
              HasSubstr("it is empty"));
}

TEST(Apply, refuses_a_recording_of_another_device) {
  const Calibration c = truth_of(exact({}));
  const InputError error = test::error_of([&] { apply(c, exact({}, 2).recording); });
  EXPECT_THAT(error.what(), HasSubstr("it has 2 magnetometers, the calibration 1"));
  Calibration broken = c;
  broken.parameters.gyr_bias[1] = NAN;
  EXPECT_THAT(test::error_of([&] { apply(broken, exact({}).recording); }).what(),
              HasSubstr("not numbers"));
  Calibration current = c;
  current.effects.push_back({"mag_current", {}});
  EXPECT_THAT(test::error_of([&] { apply(current, exact({}).recording); }).what(),
              HasSubstr("column `current`"));
}

}  // namespace
}  // namespace magimu
