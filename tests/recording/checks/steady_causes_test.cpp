// SPDX-License-Identifier: BSD-3-Clause
// What is there all the time and is no fault of single samples: vibration, times of rows, and a
// gyroscope's dead zone.
#include <gmock/gmock.h>

#include "recording/checks/gate.h"
#include "recording/checks/quality.h"
#include "recording/data/error.h"
#include "recording/oddities/dead_zone.h"
#include "tests/recording/turned_board.h"

namespace magimu {
namespace {

using testing::HasSubstr;

std::vector<Issue> issues_of_kind(const Recording& r, const std::string& kind) {
  std::vector<Issue> out = check_recording(r);
  std::erase_if(out, [&](const Issue& issue) { return issue.kind != kind; });
  return out;
}

TEST(Vibration, of_a_motor_is_found_by_its_line) {
  for (const double hz : {40.0, 90.0, 113.0}) {
    Recording r = test::turned_board(30.0, 1, 250.0);
    for (std::size_t k = 0; k < r.acc.size(); ++k) {
      const double phase = 2.0 * M_PI * hz * r.acc.t[k];
      r.acc.v[k] += Vector3(5.0 * std::sin(phase), 1.0, 2.0 * std::cos(phase));
    }
    const std::vector<Issue> found = issues_of_kind(r, "vibration");
    ASSERT_EQ(found.size(), 1u);
    EXPECT_FALSE(damages(found[0]));
    EXPECT_THAT(found[0].problem, HasSubstr("100 % of the time, by 3.8 m/s^2 RMS"));
    EXPECT_THAT(found[0].problem, HasSubstr("around " + std::to_string(int(hz))));
  }
}

TEST(Vibration, is_neither_noise_nor_knocks_nor_a_second_of_a_motor) {
  Recording noisy = test::turned_board(30.0, 1, 200.0), knocked = noisy, once = noisy;
  std::mt19937 bits(1);
  std::normal_distribution<double> noise;
  for (std::size_t k = 0; k < noisy.acc.size(); ++k) {
    noisy.acc.v[k] += Vector3(noise(bits), noise(bits), noise(bits));
    if (k % 200 == 50) knocked.acc.v[k][1] += 60.0;
    if (k < 1000) once.acc.v[k][2] += 5.0 * std::sin(2.0 * M_PI * 0.35 * double(k));
  }
  for (const Recording* r : {&noisy, &knocked, &once}) {
    EXPECT_THAT(issues_of_kind(*r, "vibration"), testing::IsEmpty());
  }
}

// The readings of a steady clock, each in the first row after it.
VectorSeries in_rows(const VectorSeries& rows, double rate_hz, double clock_jitter_s) {
  std::mt19937 bits(5);
  std::normal_distribution<double> noise(0.0, clock_jitter_s);
  VectorSeries out;
  double next = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (rows.t[k] < next) continue;
    out.push_back(rows.t[k], rows.v[k]);
    next += 1.0 / rate_hz;
    if (clock_jitter_s > 0.0) next += noise(bits);
    next = std::max(next, rows.t[k]);
  }
  return out;
}

TEST(TimesOfRows, are_right_to_a_row_where_a_rate_is_no_divisor_of_theirs) {
  for (const double rate : {80.0, 65.0, 41.0}) {
    Recording r = test::turned_board(30.0, 1, 104.0);
    r.mag[0] = in_rows(r.mag[0], rate, 0.0);
    for (const Issue& issue : check_recording(r)) {
      EXPECT_EQ(issue.severity, Severity::kNote) << rate << ": " << issue.text();
      EXPECT_THAT(issue.problem, HasSubstr("right to one row"));
    }
  }
}

TEST(TimesOfRows, do_not_excuse_times_that_jitter) {
  Recording r = test::turned_board(30.0, 1, 100.0);
  r.mag[0] = in_rows(r.mag[0], 10.0, 0.1);  // ten rows
  const std::vector<Issue> found = issues_of_kind(r, "jitter");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::kCaution);
}

// Turns with a pause of two seconds after each.
Recording with_pauses() {
  Recording r = test::turned_board(60.0, 2, 100.0);
  for (std::size_t k = 0; k < r.gyr.size(); ++k) {
    const double in_turn = std::fmod(r.gyr.t[k], 5.0);
    if (in_turn > 3.0) r.gyr.v[k] *= 0.001;
  }
  return r;
}

TEST(DeadZone, of_a_gyroscope_is_called_so) {
  Recording of_axes = with_pauses(), of_all = of_axes;
  for (Vector3& v : of_axes.gyr.v) {
    for (int i = 0; i < 3; ++i) v[i] = std::abs(v[i]) < 0.15 ? 0.0 : v[i];
  }
  // At rest it reads its bias; what is less than that away from it is written as 0.
  for (Vector3& v : of_all.gyr.v) v = v.norm() < 0.3 ? Vector3::Zero() : v;
  EXPECT_TRUE(dead_zone_of(of_axes.gyr));
  const std::optional<Recording> kept = gated(of_axes);
  ASSERT_TRUE(kept);
  ASSERT_FALSE(kept->set_aside.empty());
  for (const SetAside& s : kept->set_aside) EXPECT_EQ(s.kind, "dead_zone") << s.example;
  for (const Issue& issue : check_recording(*kept)) {
    EXPECT_THAT(issue.text(), testing::Not(HasSubstr("leave the fields empty")));
  }
}

// Within the band a device may write its bias, or anything else.
TEST(DeadZone, may_read_any_constant_and_is_no_sensor_that_hangs) {
  Recording r = with_pauses();
  const Vector3 constant(-0.00333, -0.00545, 0.0025);
  for (Vector3& v : r.gyr.v) {
    for (int i = 0; i < 3; ++i) v[i] = std::abs(v[i]) < 0.15 ? constant[i] : v[i];
  }
  r.gyr.v[7].setConstant(NAN);
  ASSERT_TRUE(dead_zone_of(r.gyr));
  EXPECT_EQ(dead_zone_of(r.gyr)->reads, constant);
  const std::optional<Recording> kept = gated(r);
  ASSERT_TRUE(kept);
  for (const SetAside& s : kept->set_aside) {
    EXPECT_EQ(s.kind, s.count > 1 ? "dead_zone" : "not_finite") << s.example;
  }
  for (const Vector3& v : kept->gyr.v) EXPECT_NE(v, constant);
  for (const Issue& issue : check_recording(*kept)) {
    EXPECT_THAT(issue.text(), testing::Not(HasSubstr("hung")));
  }
}

// The same step has other last digits each time where numbers went through single precision.
TEST(DeadZone, is_no_converter_whose_readings_were_rounded_again) {
  Recording r = with_pauses();
  std::size_t k = 0;
  for (Vector3& v : r.gyr.v) {
    for (double& x : v) x = std::round(x / 1.1e-3) * 1.1e-3 + 1e-8 * double(++k % 7);
  }
  // At rest most are the same step, some the same number.
  EXPECT_FALSE(dead_zone_of(r.gyr));
}

TEST(DeadZone, is_not_what_a_sensor_does_that_hangs_again_and_again) {
  Recording r = with_pauses();
  for (std::size_t k = 0; k < r.gyr.size(); ++k) {
    if (k % 500 > 100 && k % 500 < 180) r.gyr.v[k] = r.gyr.v[100];
  }
  EXPECT_FALSE(dead_zone_of(r.gyr));
}

TEST(DeadZone, is_no_row_without_a_sample_and_no_coarse_converter) {
  Recording empty = with_pauses(), coarse = empty;
  for (std::size_t k = 0; k < empty.gyr.size(); ++k) {
    if (k % 50 < 3) empty.gyr.v[k].setZero();
    coarse.gyr.v[k] = (coarse.gyr.v[k] / 0.02).array().round() * 0.02;
  }
  EXPECT_FALSE(dead_zone_of(empty.gyr));
  EXPECT_FALSE(dead_zone_of(coarse.gyr));
  EXPECT_FALSE(dead_zone_of(with_pauses().gyr));
}

TEST(Gate, refuses_a_sensor_that_is_mostly_clipped_for_every_purpose) {
  Recording r = test::turned_board(30.0);
  EXPECT_NO_THROW(refuse_mostly_set_aside(r));
  for (Vector3& v : r.mag[0].v) v = v.cwiseMax(-12.0).cwiseMin(12.0);
  EXPECT_THROW(refuse_mostly_set_aside(r), InputError);
}

}  // namespace
}  // namespace magimu
