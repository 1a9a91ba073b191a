// SPDX-License-Identifier: BSD-3-Clause
// What check_recording finds in recordings that were spoilt in one way each, and that it finds
// nothing in good ones.
#include "recording/checks/quality.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <random>

#include "recording/data/units.h"
#include "recording/read.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// A sensor that turns about slowly changing axes, with noise; no physics beyond that gravity and
// field turn as the rates say.
Recording good(double rate = 100.0, double seconds = 30.0, unsigned seed = 1) {
  std::mt19937 bits(seed);
  std::normal_distribution<double> noise;
  const auto random = [&] { return Vector3(noise(bits), noise(bits), noise(bits)); };
  Recording r;
  r.name = "walk.csv";
  r.mag.resize(1);
  r.mag_names = {"mag"};
  Rot3 nRb;
  for (int k = 0; k < int(rate * seconds); ++k) {
    const double t = k / rate;
    const Vector3 omega(1.5 * std::sin(0.7 * t), 1.2 * std::cos(0.5 * t), std::sin(0.3 * t + 1.0));
    r.acc.push_back(t, nRb.unrotate(Vector3(0, 0, 9.81)) + 0.03 * random());
    r.gyr.push_back(t, omega + 0.002 * random());
    r.mag[0].push_back(t, nRb.unrotate(Vector3(0, 18, -45)) + Vector3(5, -3, 2) + 0.2 * random());
    nRb = (nRb * Rot3::Exp(omega / rate)).normalized();
  }
  return r;
}

void scale(VectorSeries& s, double factor) {
  for (Vector3& v : s.v) v *= factor;
}
void scale_time(VectorSeries& s, double factor) {
  for (double& t : s.t) t *= factor;
}
void erase(VectorSeries& s, std::size_t from, std::size_t to) {
  s.t.erase(s.t.begin() + long(from), s.t.begin() + long(to));
  s.v.erase(s.v.begin() + long(from), s.v.begin() + long(to));
}
// Every ratio-th sample as measured, the others on lines between them, or held.
void slow_clock(VectorSeries& s, std::size_t ratio, bool on_lines) {
  const VectorSeries own = s;
  for (std::size_t k = 0; k < s.size(); ++k) {
    const std::size_t a = k / ratio * ratio, b = std::min(a + ratio, s.size() - 1);
    const double share = on_lines ? double(k - a) / double(ratio) : 0.0;
    s.v[k] = (1.0 - share) * own.v[a] + share * own.v[b];
  }
}

// Every nth row is of another device.
void mix(VectorSeries& s, std::size_t n) {
  for (std::size_t k = 1; k < s.size(); k += n) {
    s.v[k] = s.v[k].cwiseProduct(Vector3(1.03, 0.96, 1.01)) + Vector3(3.0, -2.0, 4.0);
  }
}

// Every nth sample is that of half a recording later.
void mix_with_later(VectorSeries& s, std::size_t n) {
  const std::vector<Vector3> alone = s.v;
  for (std::size_t k = 2; k < s.size(); k += n) s.v[k] = alone[(k + s.size() / 2) % s.size()];
}

struct Spoilt {
  std::string name, kind, sensor;
  Severity severity;
  std::string problem, remedy;  // words in the message
  std::function<void(Recording&)> spoil;
};

void PrintTo(const Spoilt& spoilt, std::ostream* out) { *out << spoilt.name; }

class Quality : public testing::TestWithParam<Spoilt> {};

TEST_P(Quality, is_found_named_and_mended) {
  const Spoilt& spoilt = GetParam();
  Recording r = good();
  spoilt.spoil(r);
  const std::vector<Issue> issues = check_recording(r);
  ASSERT_FALSE(issues.empty());
  EXPECT_EQ(issues[0].kind, spoilt.kind) << issues[0].text();
  EXPECT_EQ(issues[0].sensor, spoilt.sensor);
  EXPECT_EQ(issues[0].severity, spoilt.severity);
  EXPECT_THAT(issues[0].problem, HasSubstr(spoilt.problem));
  EXPECT_THAT(issues[0].remedy, HasSubstr(spoilt.remedy));
  for (const Issue& issue : issues) EXPECT_EQ(issue.kind, spoilt.kind) << issue.text();
  if (spoilt.severity == Severity::kFatal) {
    const InputError error = test::error_of([&] { refuse_fatal(r, issues); });
    EXPECT_THAT(error.what(), AllOf(HasSubstr("walk.csv"), HasSubstr(spoilt.problem)));
  } else {
    refuse_fatal(r, issues);
  }
}

const double kNoNumber = std::numeric_limits<double>::quiet_NaN();
const Severity kFatal = Severity::kFatal, kCaution = Severity::kCaution, kNote = Severity::kNote;

const std::vector<Spoilt> kSpoilt{
    {"nan", "not_finite", "gyr", kFatal,
     "3 samples that are not finite numbers, the first at 1.000", "leave out",
     [](Recording& r) {
       for (int k : {100, 101, 900}) r.gyr.v[std::size_t(k)][1] = kNoNumber;
     }},
    {"infinite_time", "not_finite", "acc", kFatal, "not finite", "leave out",
     [](Recording& r) { r.acc.t[5] = INFINITY; }},
    {"backwards", "time_order", "mag", kFatal, "goes backwards at 2.990", "clock was set back",
     [](Recording& r) {
       r.mag[0].t[300] = 2.990;
       r.mag[0].t[299] = 2.995;
     }},
    {"duplicate", "time_order", "gyr", kFatal, "is repeated at 3.000", "delete repeated ones",
     [](Recording& r) { r.gyr.t[301] = r.gyr.t[300]; }},
    {"gap", "gap", "gyr", kCaution, "a gap at 9.99-10.50 s: about 50 samples are missing",
     "a new part of the recording begins", [](Recording& r) { erase(r.gyr, 1000, 1050); }},
    {"gap_of_all", "gap", "acc", kNote, "a gap at 9.99-15.00 s", "the logger paused",
     [](Recording& r) {
       for (VectorSeries* s : {&r.acc, &r.gyr, &r.mag[0]}) erase(*s, 1000, 1500);
     }},
    {"gaps", "gap", "acc", kCaution, "2 gaps, at 19.99-20.20 s, 4.99-5.10 s",
     "slow the logger down",
     [](Recording& r) {
       erase(r.acc, 2000, 2020);
       erase(r.acc, 500, 510);
     }},
    {"jitter", "jitter", "acc", kCaution, "jitter: 5 % of its intervals", "the sensor measured",
     [](Recording& r) {
       for (std::size_t k = 0; k < r.acc.size(); k += 3) r.acc.t[k] += 0.007;
     }},
    {"heaps", "jitter", "acc", kCaution, "several at once: most are 0.001 ms apart, but there are",
     "the sensor measured",
     [](Recording& r) {
       // Bursts of three or more, as random as their distances.
       const std::vector<double> own = r.acc.t;
       double last = -1.0, late = 0.0;
       for (std::size_t k = 0; k < r.acc.size(); ++k) {
         if (k % 3 == 0) late = 0.005 * std::abs(std::sin(double(k * k)));
         last = std::max(last + 1e-6, own[k - k % 3] + late);
         r.acc.t[k] = last;
       }
     }},
    {"span", "span", "mag", kCaution, "from 15.00 to 29.99 s only", "from begin to end",
     [](Recording& r) { erase(r.mag[0], 0, 1500); }},
    {"milliseconds", "time_unit", "acc", kFatal, "it seems to be in ms", "--unit t=ms",
     [](Recording& r) {
       for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) scale_time(*s, 1e3);
     }},
    {"microseconds", "time_unit", "acc", kFatal, "it seems to be in us", "--unit t=us",
     [](Recording& r) {
       for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) scale_time(*s, 1e6);
     }},
    // The gyroscope is in order, and what its rates are compared with is not.
    {"minutes", "time_unit", "gyr", kFatal, "the times seem to be in minutes", "--unit t=60",
     [](Recording& r) {
       for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) scale_time(*s, 1.0 / 60.0);
     }},
    {"tenths_of_ms_read_as_ms", "time_unit", "gyr", kFatal, "tenths of a millisecond",
     "--unit t=0.0001 (in memory: multiply the times by 0.1)",
     [](Recording& r) {
       for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) scale_time(*s, 10.0);
       r.file_units["t"] = 1e-3;
     }},
    {"numbers_of_samples", "time_unit", "gyr", kFatal, "the times count samples", "--rate 1",
     [](Recording& r) {
       for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) {
         for (std::size_t k = 0; k < s->size(); ++k) s->t[k] = double(k);
       }
     }},
    {"constant_axis", "constant", "gyr", kFatal, "gyr_z is 0 rad/s in all 3000 samples",
     "not measured",
     [](Recording& r) {
       for (Vector3& v : r.gyr.v) v[2] = 0.0;
     }},
    {"copied_axis", "copied", "mag", kFatal, "mag_x and mag_z hold the same numbers in 100 %",
     "written twice",
     [](Recording& r) {
       for (Vector3& v : r.mag[0].v) v[2] = -v[0];
     }},
    {"stuck", "stuck", "mag", kCaution, "does not change at all for 1.99 s from 10.00 s", "hung",
     [](Recording& r) {
       for (std::size_t k = 1000; k < 1200; ++k) r.mag[0].v[k] = r.mag[0].v[1000];
     }},
    {"zeros", "zeros", "acc", kCaution, "exactly 0, 0, 0 in 7 samples, first at 1.000 s", "empty",
     [](Recording& r) {
       for (std::size_t k = 100; k < 800; k += 100) r.acc.v[k].setZero();
     }},
    {"clipped", "saturation", "gyr", kCaution, "gyr_x reads 1.2 rad/s, its largest, in",
     "larger range",
     [](Recording& r) {
       for (Vector3& v : r.gyr.v) v[0] = std::min(v[0], 1.2);
     }},
    {"clipped_below", "saturation", "mag", kCaution, "mag_z reads -30 uT, its smallest",
     "the magnet",
     [](Recording& r) {
       for (Vector3& v : r.mag[0].v) v[2] = std::max(v[2], -30.0);
     }},
    {"held", "repeats", "mag", kNote,
     "75 % of the samples of mag repeat the one before: its own rate "
     "is about 25",
     "left out", [](Recording& r) { slow_clock(r.mag[0], 4, false); }},
    {"interpolated", "interpolation", "mag", kCaution,
     "75 % of the samples of mag lie on straight "
     "lines between their neighbours: they are interpolated from a clock of about 25",
     "own samples", [](Recording& r) { slow_clock(r.mag[0], 4, true); }},
    {"interpolated_by_two_and_rounded", "interpolation", "mag", kCaution, "of about 50",
     "own samples",
     [](Recording& r) {
       slow_clock(r.mag[0], 2, true);
       for (Vector3& v : r.mag[0].v) v = (v * 1e3).array().round() / 1e3;
     }},
    {"rows_of_two_devices", "mixed", "mag", kCaution, "every second sample of mag stands out",
     "separate them", [](Recording& r) { mix(r.mag[0], 2); }},
    {"every_third_row_of_another", "mixed", "mag", kCaution, "every third sample of mag",
     "separate", [](Recording& r) { mix(r.mag[0], 3); }},
    {"every_fourth_row_of_another", "mixed", "mag", kCaution, "every fourth sample of mag",
     "separate", [](Recording& r) { mix(r.mag[0], 4); }},
    {"every_fifth_row_of_one_that_is_turned_otherwise", "mixed", "acc", kCaution,
     "every 5th sample of acc stands out", "separate",
     [](Recording& r) { mix_with_later(r.acc, 5); }},
    {"every_tenth_row_of_one_that_is_turned_otherwise", "mixed", "mag", kCaution,
     "every 10th sample of mag stands out", "separate",
     [](Recording& r) { mix_with_later(r.mag[0], 10); }},
    {"acc_in_g", "unit", "acc", kFatal, "it is in g", "--unit acc=g",
     [](Recording& r) { scale(r.acc, 1 / 9.80665); }},
    {"acc_in_mg", "unit", "acc", kFatal, "it is in mg", "--unit acc=mg",
     [](Recording& r) { scale(r.acc, 1e3 / 9.80665); }},
    {"acc_in_counts", "unit", "acc", kFatal, "counts of the converter", "--unit acc=0.0005",
     [](Recording& r) { scale(r.acc, 16384 / 9.80665); }},
    {"acc_without_gravity", "gravity", "acc", kFatal, "without gravity", "total acceleration",
     [](Recording& r) {
       for (Vector3& v : r.acc.v) v *= 0.05;
     }},
    // As large as a g in g, but for the rests.
    {"acc_without_gravity_of_a_lively_hand", "gravity", "acc", kFatal, "without gravity",
     "total acceleration",
     [](Recording& r) {
       for (std::size_t k = 0; k < r.acc.size(); ++k) {
         const double s = 0.3 * double(k), size = k < r.acc.size() / 12 ? 0.001 : 1.0;
         r.acc.v[k] = Vector3(0.1, 0.05, -0.05) + size * Vector3(sin(s), cos(s), sin(1.7 * s));
       }
     }},
    {"gyr_in_degrees", "unit", "gyr", kFatal, "seems to be in deg/s", "--unit gyr=deg/s",
     [](Recording& r) { scale(r.gyr, 180 / M_PI); }},
    {"gyr_in_millidegrees", "unit", "gyr", kFatal, "seems to be in mdeg/s", "--unit gyr=mdeg/s",
     [](Recording& r) { scale(r.gyr, 180e3 / M_PI); }},
    // As near to mrad/s as to 16.4 counts a deg/s, by what a hand lets be measured.
    {"gyr_near_two_units", "unit", "gyr", kFatal, "seems to be in mrad/s", "--unit gyr=mrad/s",
     [](Recording& r) { scale(r.gyr, 965.0); }},
    {"gyr_near_two_units_in_whole_numbers", "unit", "gyr", kFatal, "counts of the converter, 16.4",
     "--unit gyr=0.001064",
     [](Recording& r) {
       scale(r.gyr, 965.0);
       for (Vector3& v : r.gyr.v) v = v.array().round();
     }},
    {"stuck_axis", "stuck", "gyr", kCaution, "gyr_y does not change at all for 1.99 s from 10.00 s",
     "hung",
     [](Recording& r) {
       for (std::size_t k = 1000; k < 1200; ++k) r.gyr.v[k][1] = r.gyr.v[1000][1];
     }},
    {"stuck_axis_at_an_extreme", "stuck", "acc", kCaution,
     "acc_x does not change at all for 1.99 s from 10.00 s", "hung",
     [](Recording& r) {
       for (std::size_t k = 1000; k < 1200; ++k) r.acc.v[k][0] = 30.0;
     }},
    {"stuck_axis_at_its_largest_to_the_end", "stuck", "gyr", kCaution,
     "gyr_z does not change at all for", "hung",
     [](Recording& r) {
       for (std::size_t k = 0; k < r.gyr.size(); ++k) {  // a noisy one
         r.gyr.v[k][2] += 0.3 * std::sin(12.9898 * double(k) * double(k));
       }
       std::size_t at = r.gyr.size() / 2;
       for (std::size_t k = at; k + 1000 < r.gyr.size(); ++k) {
         if (r.gyr.v[k][2] > r.gyr.v[at][2]) at = k;
       }
       const double most = r.gyr.v[at][2];
       for (std::size_t k = 0; k < r.gyr.size(); ++k) {
         double& z = r.gyr.v[k][2];
         z = k > at ? most : z > most ? 2.0 * most - z : z;
       }
     }},
    {"gyr_range_taken_for_twice", "unit", "gyr", kFatal, "its range was set to 1/2 of",
     "--unit gyr=0.5", [](Recording& r) { scale(r.gyr, 2.0); }},
    {"gyr_range_taken_for_half", "unit", "gyr", kFatal, "its range was set to 2 times",
     "--unit gyr=2", [](Recording& r) { scale(r.gyr, 0.5); }},
    {"gyr_in_tenths_of_degrees", "unit", "gyr", kFatal, "10 a deg/s", "--unit gyr=0.001745",
     [](Recording& r) { scale(r.gyr, 1800 / M_PI); }},
    {"gyr_in_counts", "unit", "gyr", kFatal, "16.4 a deg/s", "--unit gyr=0.001064",
     [](Recording& r) { scale(r.gyr, 16.4 * 180 / M_PI); }},
    {"slow_gyr_in_degrees", "unit", "gyr", kFatal, "it seems to be in deg/s", "--unit gyr=deg/s",
     [](Recording& r) {  // ten times slower, so that the readings themselves are not large
       for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) scale_time(*s, 10.0);
       scale(r.gyr, 18 / M_PI);
     }},
    {"acc_two_per_cent", "acc_scale", "acc", kCaution, "2.0 % too much", "--unit acc=0.98",
     [](Recording& r) { scale(r.acc, 1.02 * 9.80665 / 9.81); }},
    {"mag_in_counts", "unit", "mag", kFatal, "no usual unit fits", "--unit mag=0.01",
     [](Recording& r) {
       for (Vector3& v : r.mag[0].v) v = (v * 68.42).array().round();
     }},
    {"mag_normalised", "normalised", "mag", kFatal, "the same length", "raw readings",
     [](Recording& r) {
       for (Vector3& v : r.mag[0].v) v *= 50.0 / v.norm();
     }},
    {"mag_normalised_and_rounded", "normalised", "mag", kFatal, "the same length", "raw readings",
     [](Recording& r) {
       for (Vector3& v : r.mag[0].v) v = (v.normalized() * 1e4).array().round() / 1e4;
     }},
    {"mag_in_gauss", "unit", "mag", kFatal, "gauss", "--unit mag=gauss",
     [](Recording& r) { scale(r.mag[0], 0.01); }},
    {"mag_in_milligauss", "unit", "mag", kFatal, "milligauss", "--unit mag=mG",
     [](Recording& r) { scale(r.mag[0], 10); }},
    {"mag_in_nanotesla", "unit", "mag", kFatal, "nanotesla", "--unit mag=nT",
     [](Recording& r) { scale(r.mag[0], 1e3); }},
    {"mag_in_tesla", "unit", "mag", kFatal, "tesla", "--unit mag=T",
     [](Recording& r) { scale(r.mag[0], 1e-6); }},
};

INSTANTIATE_TEST_SUITE_P(OfARecording, Quality, testing::ValuesIn(kSpoilt),
                         [](const auto& spoilt) { return spoilt.param.name; });

TEST(Quality, normalised_readings_are_found_where_the_sensor_mostly_lay_still) {
  Recording r = good();
  const std::size_t moved = r.mag[0].size() / 5;
  for (std::size_t k = moved; k < r.mag[0].size(); ++k) {
    r.mag[0].v[k] = r.mag[0].v[moved] + 0.02 * r.mag[0].v[k];
  }
  const auto found = [&] {
    return std::ranges::any_of(check_recording(r),
                               [](const Issue& issue) { return issue.kind == "normalised"; });
  };
  EXPECT_FALSE(found());
  for (Vector3& v : r.mag[0].v) v *= 50.0 / v.norm();
  EXPECT_TRUE(found());
}

// A unit is that of the whole file.
TEST(Quality, what_changes_in_mid_recording_is_no_wrong_unit) {
  const auto units_at_fault = [](const Recording& r) {
    const auto issues = check_recording(r);
    return std::ranges::count_if(issues, [](const Issue& i) { return i.kind == "unit"; });
  };
  for (const double begin : {8.0, 13.0, 18.0}) {
    Recording switched = good();  // the gyroscope's range
    for (std::size_t k = 0; k < switched.gyr.size(); ++k) {
      if (switched.gyr.t[k] > begin) switched.gyr.v[k] *= 2.0;
    }
    EXPECT_EQ(units_at_fault(switched), 0) << begin;
    Recording beside_magnet = good();
    VectorSeries& mag = beside_magnet.mag[0];
    for (std::size_t k = 0; k < mag.size(); ++k) {
      if (mag.t[k] > begin && mag.t[k] < begin + 5.0) mag.v[k] += Vector3(500.0, -200.0, 300.0);
    }
    EXPECT_EQ(units_at_fault(beside_magnet), 0) << begin;
  }
}

TEST(Quality, a_gyroscope_whose_range_is_switched_is_told_with_its_times) {
  Recording r = good(100.0, 120.0);
  for (std::size_t k = 0; k < r.gyr.size(); ++k) {
    if (r.gyr.t[k] > 40.0) r.gyr.v[k] *= 2.0;
  }
  const auto issues = check_recording(r);
  const auto found = std::ranges::find(issues, "gain_changes", &Issue::kind);
  ASSERT_NE(found, issues.end());
  EXPECT_THAT(found->problem, HasSubstr("reads 1.0"));
  EXPECT_THAT(found->problem, HasSubstr("times: its range was switched"));
  EXPECT_THAT(found->remedy, HasSubstr("cut the recording"));
}

// A board asks the network for the time: memory follows the samples, quarters too.
TEST(Quality, a_clock_that_was_set_ahead_by_decades_costs_nothing) {
  Recording r = good(100.0, 120.0);
  const auto set_ahead = [](VectorSeries& s, double from) {
    for (double& t : s.t) t += t > from ? 1.79e9 : 0.0;
  };
  for (VectorSeries* s : {&r.acc, &r.gyr, &r.mag[0]}) set_ahead(*s, 70.0);
  EXPECT_NO_THROW(check_recording(r));
  for (std::size_t k = 0; k < r.gyr.size(); ++k) {
    if (r.gyr.t[k] > 40.0) r.gyr.v[k] *= 2.0;
  }
  const auto issues = check_recording(r);
  EXPECT_NE(std::ranges::find(issues, "gain_changes", &Issue::kind), issues.end());
}

TEST(Quality, advice_does_not_ask_for_the_unit_that_was_given) {
  Recording r = good();
  scale(r.gyr, 2.0);
  r.file_units["gyr"] = M_PI / 180.0;
  std::vector<Issue> issues = check_recording(r);
  ASSERT_EQ(issues.size(), 1u);
  EXPECT_THAT(issues[0].remedy, HasSubstr("--unit gyr=0.00872665"));
  r = good();
  for (Vector3& v : r.mag[0].v) v = (v * 68.42).array().round() * 0.1;
  r.file_units["mag"] = 0.1;
  issues = check_recording(r);
  ASSERT_EQ(issues.size(), 1u);
  EXPECT_THAT(issues[0].remedy, AllOf(HasSubstr("--unit mag=0.01"), testing::Not(HasSubstr("mG"))));
}

// Of a recording that no file has given.
TEST(Quality, advice_on_units_serves_readings_in_memory_too) {
  const auto remedy_of = [](const auto& spoil) {
    Recording r = good();
    spoil(r);
    return check_recording(r).front().remedy;
  };
  EXPECT_THAT(remedy_of([](Recording& r) { scale(r.gyr, 180.0 / M_PI); }),
              HasSubstr("--unit gyr=deg/s (in memory: multiply gyr by 0.0174533)"));
  EXPECT_THAT(remedy_of([](Recording& r) { scale(r.mag[0], 1e3); }),
              HasSubstr("--unit mag=nT (in memory: multiply mag by 0.001)"));
  EXPECT_THAT(remedy_of([](Recording& r) {
                scale(r.gyr, 2.0);
                r.file_units["gyr"] = M_PI / 180.0;
              }),
              HasSubstr("(in memory: multiply gyr by 0.5)"));
  EXPECT_THAT(remedy_of([](Recording& r) {
                for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) scale_time(*s, 1e3);
              }),
              HasSubstr("--unit t=ms (in memory: multiply the times by 0.001)"));
}

void count(VectorSeries& series, double in_ours) {
  for (Vector3& v : series.v) v = (v / in_ours).array().round();
}

TEST(Quality, where_the_imu_counts_so_does_the_magnetometer) {
  Recording r = good();
  count(r.acc, 9.80665 / 16384);
  count(r.gyr, M_PI / 180 / 131);
  count(r.mag[0], 0.15);
  const std::vector<Issue> issues = check_recording(r);
  ASSERT_EQ(issues.size(), 3u);
  EXPECT_THAT(issues[0].remedy, HasSubstr("--unit acc=0.00059855"));
  EXPECT_THAT(issues[1].remedy, HasSubstr("--unit gyr=0.000133231"));
  EXPECT_THAT(issues[2].problem, HasSubstr("counts of a converter"));
  EXPECT_THAT(issues[2].remedy, HasSubstr("--unit mag=0.15 (AK8963"));
  EXPECT_THAT(issues[2].remedy, HasSubstr("--unit mag=0.0917431 (HMC5883L"));
  EXPECT_THAT(issues[2].remedy, testing::Not(HasSubstr("QMC5883L at 2 G")));
  const InputError error = test::error_of([&] { refuse_fatal(r, issues); });
  EXPECT_THAT(error.remedy, AllOf(HasSubstr("give the file's units: --unit acc=0.00059855"),
                                  HasSubstr("--unit gyr="), HasSubstr("--unit mag=0.15")));
}

TEST(Quality, whole_numbers_may_be_counts_or_a_unit_and_all_that_fit_are_named) {
  for (const double count_uT : {1.0 / 16, 0.15}) {
    Recording r = good();
    count(r.mag[0], count_uT);
    const std::vector<Issue> issues = check_recording(r);
    ASSERT_EQ(issues.size(), 1u);
    EXPECT_THAT(issues[0].problem, HasSubstr("milligauss, or in counts"));
    EXPECT_THAT(issues[0].remedy, HasSubstr("mG (milligauss"));
    EXPECT_THAT(issues[0].remedy, HasSubstr(count_uT == 0.15 ? "mag=0.15 (" : "mag=0.0625 ("));
  }
}

TEST(Quality, counts_of_a_bno055_are_found_by_all_three_sensors) {
  Recording r = good();
  count(r.acc, 0.01);
  count(r.gyr, M_PI / 180 / 16);
  count(r.mag[0], 1.0 / 16);
  const std::vector<Issue> issues = check_recording(r);
  ASSERT_EQ(issues.size(), 3u);
  EXPECT_THAT(issues[0].remedy, HasSubstr("--unit acc=cm/s^2 or --unit acc=mg"));
  EXPECT_THAT(issues[1].remedy, HasSubstr("--unit gyr=0.00109083"));
  EXPECT_THAT(issues[2].remedy, HasSubstr("--unit mag=0.0625 (BNO055"));
}

// A hand that turns the device and moves it: gravity is there, or not.
Recording moved(double gravity, double size) {
  Recording r = good(100.0, 40.0);
  Rot3 nRb;
  for (std::size_t k = 0; k < r.acc.size(); ++k) {
    const double t = r.acc.t[k];
    const Vector3 a = size * Vector3(std::sin(6.0 * t), std::cos(4.5 * t), std::sin(5.2 * t + 1.0));
    r.acc.v[k] = nRb.unrotate(Vector3(0, 0, gravity) + a) + Vector3(0.02, -0.01, 0.03);
    nRb = (nRb * Rot3::Exp(r.gyr.v[k] * 0.01)).normalized();
  }
  return r;
}

TEST(Quality, acceleration_without_gravity_is_told_by_the_numbers_whatever_their_size) {
  for (const double size : {0.3, 1.0, 3.0, 9.8, 500.0, 9800.0}) {
    const std::vector<Issue> issues = check_recording(moved(0.0, size));
    ASSERT_FALSE(issues.empty()) << size;
    EXPECT_TRUE(std::ranges::any_of(issues,
                                    [](const Issue& issue) {
                                      return issue.kind == "gravity" &&
                                             issue.severity == Severity::kFatal;
                                    }))
        << size << issues.front().text();
  }
}

TEST(Quality, gravity_is_seen_in_a_lively_hand_and_with_turned_axes) {
  for (const double size : {0.0, 1.0, 5.0, 10.0}) {
    for (const bool turned : {false, true}) {
      Recording r = moved(9.81, size);
      if (turned) {
        for (Vector3& v : r.acc.v) v = Vector3(v[1], -v[0], v[2]);
      }
      for (const Issue& issue : check_recording(r)) EXPECT_NE(issue.kind, "gravity") << size;
    }
  }
}

TEST(Quality, arbitrary_units_of_the_file_are_told_of) {
  Recording r = good();
  r.file_units["mag"] = kArbitraryField;
  const std::vector<Issue> issues = check_recording(r);
  ASSERT_EQ(issues.size(), 1u);
  EXPECT_EQ(issues[0].kind, "arbitrary_unit");
  EXPECT_EQ(issues[0].severity, Severity::kNote);
}

TEST(Quality, a_unit_that_would_give_no_field_of_the_earth_is_no_advice) {
  Recording r = good();
  double most = 0.0;
  for (const Vector3& v : r.mag[0].v) most = std::max(most, v.cwiseAbs().maxCoeff());
  scale(r.mag[0], 0.95 / most);  // to the local field's strength, nearly
  std::vector<Issue> issues = check_recording(r);
  ASSERT_EQ(issues.size(), 1u);
  EXPECT_THAT(issues[0].problem, HasSubstr("perhaps it was scaled"));
  EXPECT_THAT(issues[0].remedy, testing::Not(HasSubstr("--unit mag=gauss")));
  scale(r.mag[0], 100.0);
  r.file_units["mag"] = 100.0;
  issues = check_recording(r);
  ASSERT_EQ(issues.size(), 1u);
  EXPECT_EQ(issues[0].kind, "field_size");
}

TEST(GoodRecordings, raise_no_alarm) {
  for (const double rate : {25.0, 100.0, 400.0}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      for (const Issue& issue : check_recording(good(rate, 30.0, seed)))
        ADD_FAILURE() << issue.text();
    }
  }
}

// Gravity goes round on a cone: through its circle, spheres of any size go, and a little motion
// decides which.
TEST(GoodRecordings, what_is_turned_on_a_tilted_table_has_no_wrong_scale) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 bits(seed);
    std::normal_distribution<double> noise;
    Recording r = good(100.0, 60.0, seed);
    Vector3 shaken = Vector3::Zero();
    for (std::size_t k = 0; k < r.acc.size(); ++k) {
      const double turn = 0.7 * r.acc.t[k] + std::sin(0.31 * r.acc.t[k]);
      shaken = 0.98 * shaken + 0.03 * Vector3(noise(bits), noise(bits), noise(bits));
      r.acc.v[k] = 9.81 * Vector3(0.8 * std::cos(turn), 0.8 * std::sin(turn), 0.6) + shaken;
    }
    for (const Issue& issue : check_recording(r)) EXPECT_NE(issue.kind, "acc_scale") << seed;
  }
}

TEST(GoodRecordings, a_slower_magnetometer_and_coarse_steps_raise_no_alarm) {
  Recording r = good();
  VectorSeries slow;
  for (std::size_t k = 0; k < r.mag[0].size(); k += 5) {
    slow.push_back(r.mag[0].t[k], (r.mag[0].v[k] / 0.15).array().round() * 0.15);
  }
  r.mag[0] = slow;
  for (Vector3& v : r.acc.v) v = (v / 0.0048).array().round() * 0.0048;
  for (Vector3& v : r.gyr.v) v = (v / 0.001).array().round() * 0.001;
  for (const Issue& issue : check_recording(r)) ADD_FAILURE() << issue.text();
}

// A coarse converter reads one value for a second where its axis changes slowly, and goes on by a
// step: it does not hang. A gyroscope in counts seems to turn while it rests.
TEST(GoodRecordings, a_slow_axis_of_a_coarse_converter_does_not_hang) {
  const auto hangs = [](const Recording& r) {
    return std::ranges::any_of(check_recording(r),
                               [](const Issue& issue) { return issue.kind == "stuck"; });
  };
  Recording slow = good();
  VectorSeries& mag = slow.mag[0];
  for (std::size_t k = 1000; k <= 1150; ++k) {
    mag.v[k][1] = 0.1 * std::round(10.0 * mag.v[999][1]) + 4e-4 * double(k - 1000);
  }
  Recording hung = slow;
  for (std::size_t k = 1150; k < 1300; ++k) hung.mag[0].v[k][1] = mag.v[1000][1];
  for (Recording* r : {&slow, &hung}) {
    for (Vector3& v : r->mag[0].v) v = (v / 0.1).array().round() * 0.1;
  }
  EXPECT_FALSE(hangs(slow));
  EXPECT_TRUE(hangs(hung));
  Recording counts = good();
  for (std::size_t k = 0; k < 100; ++k) {
    counts.gyr.v[k] = Vector3::Constant(k % 2 == 0 ? 0.002 : -0.002);
    counts.mag[0].v[k] = counts.mag[0].v[100];
  }
  scale(counts.gyr, 16.4 * 180 / M_PI);
  EXPECT_FALSE(hangs(counts));
}

TEST(GoodRecordings, a_sensor_at_rest_has_no_wrong_units) {
  Recording r = good();
  for (std::size_t k = 0; k < r.acc.size(); ++k) {
    r.acc.v[k] = Vector3(0, 0, 9.81) + 0.01 * r.gyr.v[k % 100];
    r.mag[0].v[k] = Vector3(300, 18, -45) + 0.1 * r.gyr.v[(k + 7) % 100];  // strong hard iron
    r.gyr.v[k] *= 0.001;
  }
  for (const Issue& issue : check_recording(r)) ADD_FAILURE() << issue.text();
}

TEST(RealRecordings, have_interpolated_magnetometers_and_nothing_else) {
  const std::filesystem::path folder = std::filesystem::path(MAGIMU_DATA_DIR) / "broad";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the BROAD recordings are not there";
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".hdf5" && file.path().extension() != ".mat") continue;
    SCOPED_TRACE(file.path().filename());
    const std::vector<Issue> issues = check_recording(read_recording(file.path().string()));
    ASSERT_EQ(issues.size(), 1u);
    EXPECT_EQ(issues[0].kind, "interpolation");
    EXPECT_THAT(issues[0].problem, HasSubstr("interpolated from a clock of about 14"));
  }
}

}  // namespace
}  // namespace magimu
