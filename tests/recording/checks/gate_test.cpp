// SPDX-License-Identifier: BSD-3-Clause
// What the gate sets aside of recordings that were spoilt in one way each (gate_oddities_test.cpp:
// what it leaves). tests/sim/gate_test.cpp does the same with simulations.
#include "recording/checks/gate.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>
#include <set>

#include "recording/checks/quality.h"
#include "recording/data/set_aside.h"
#include "recording/live/live_gate.h"
#include "recording/oddities/sensor_gate.h"
#include "recording/read.h"
#include "tests/recording/checks/turning_device.h"

namespace magimu {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using test::round_to;
using test::series_of;
using test::turning;

struct Fault {
  std::string name, sensor, kind;
  std::string example;  // words in it
  // Spoils the sensor and says which of its samples are no measurements any more.
  std::function<std::set<std::size_t>(VectorSeries&)> spoil;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

std::set<std::size_t> range(std::size_t begin, std::size_t end) {
  std::set<std::size_t> out;
  for (std::size_t k = begin; k < end; ++k) out.insert(k);
  return out;
}

std::set<std::size_t> hold(VectorSeries& s, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) s.v[k] = s.v[begin];
  return range(begin + 1, end);  // the first was measured
}

std::set<std::size_t> each(VectorSeries& s, std::size_t every,
                           const std::function<void(Vector3&)>& change) {
  std::set<std::size_t> out;
  for (std::size_t k = 17; k < s.size(); k += every) {
    change(s.v[k]);
    out.insert(k);
  }
  return out;
}

// Now and then, of that size on each axis; towards the end of another.
std::set<std::size_t> garbage(VectorSeries& s, double size, double size_at_the_end) {
  std::mt19937 bits(11);
  const auto part = [&] { return (bits() % 2 == 0 ? 1.0 : -1.0) * double(80 + bits() % 40) / 100; };
  double now = size;
  std::set<std::size_t> out =
      each(s, 97, [&](Vector3& v) { v += now * Vector3(part(), part(), part()); });
  now = size_at_the_end;
  for (const std::size_t k : {6450U, 6470U}) {
    s.v[k] += now * Vector3(part(), part(), part());
    out.insert(k);
  }
  return out;
}

std::set<std::size_t> wrap(VectorSeries& s, int axis, double limit) {
  std::set<std::size_t> out;
  for (std::size_t k = 0; k < s.size(); ++k) {
    double& x = s.v[k][axis];
    if (std::abs(x) <= limit) continue;
    x -= std::copysign(2.0 * limit, x);
    out.insert(k);
  }
  return out;
}

const std::vector<Fault> kFaults{
    {"nan", "gyr", "not_finite", "gyr_y = nan rad/s at 20.00 s",
     [](VectorSeries& s) {
       s.v[2000][1] = kNaN;
       return range(2000, 2001);
     }},
    {"infinite_from_the_first_sample_on", "mag", "not_finite", "inf uT at 0.00 s",
     [](VectorSeries& s) {
       for (std::size_t k = 0; k < 3; ++k) s.v[k][2] = INFINITY;
       return range(0, 3);
     }},
    {"beyond_any_range", "acc", "range", "acc_x = 1e+20 m/s^2 at 36.00 s",
     [](VectorSeries& s) {
       s.v[3600][0] = 1e20;
       return range(3600, 3601);
     }},
    {"a_lost_decimal_point", "acc", "range", "acc_z = 73813",
     [](VectorSeries& s) {
       s.v[3600][2] = 73813.0;
       return range(3600, 3601);
     }},
    {"a_jump_of_one_axis", "mag", "spike", "mag_x = 180 uT at 36.00 s (neighbours read",
     [](VectorSeries& s) {
       s.v[3600][0] = 180.0;
       return range(3600, 3601);
     }},
    {"a_row_of_garbage", "gyr", "spike", "rad/s at 36.00 s",
     [](VectorSeries& s) {
       s.v[3600] = Vector3(-41.0, 173.0, 89.0);
       return range(3600, 3601);
     }},
    // Below what a part can read. The last ones are small: of the kind of those before them.
    {"garbage_on_all_axes_again_and_again", "acc", "spike", "m/s^2 at 0.17 s",
     [](VectorSeries& s) { return garbage(s, 16.0, 0.5); }},
    {"garbage_of_a_magnetometer_again_and_again", "mag", "spike", "uT at 0.17 s",
     [](VectorSeries& s) { return garbage(s, 150.0, 8.0); }},
    {"three_rows_of_garbage", "acc", "spike", "m/s^2 at 36.00 s",
     [](VectorSeries& s) {
       s.v[3600] = Vector3(4100.0, 1730.0, -890.0);
       s.v[3601] = Vector3(-4200.0, 2730.0, -890.0);
       s.v[3602] = Vector3(4900.0, -1230.0, 7890.0);
       return range(3600, 3603);
     }},
    {"garbage_to_begin_with", "mag", "spike", "mag_y = 4100 uT at 0.00 s",
     [](VectorSeries& s) {
       s.v[0][1] = 4100.0;
       return range(0, 1);
     }},
    {"a_bus_that_hangs_for_a_second", "mag", "stuck", "at 20.01 s",
     [](VectorSeries& s) { return hold(s, 2000, 2100); }},
    {"a_gyroscope_that_hangs", "gyr", "stuck", "at 20.01 s",
     [](VectorSeries& s) { return hold(s, 2000, 2150); }},
    {"a_sensor_that_hangs_to_the_end", "acc", "stuck", "at 50.01 s",
     [](VectorSeries& s) { return hold(s, 5000, 6500); }},
    {"rows_of_zeros", "mag", "zeros", "mag = (0, 0, 0) uT at 0.17 s",
     [](VectorSeries& s) { return each(s, 40, [](Vector3& v) { v.setZero(); }); }},
    {"a_gyroscope_of_zeros_for_a_second", "gyr", "zeros", "gyr = (0, 0, 0) rad/s at 20.00 s",
     [](VectorSeries& s) {
       for (std::size_t k = 2000; k < 2100; ++k) s.v[k].setZero();
       return range(2000, 2100);
     }},
    {"an_overflow_value", "mag", "sentinel", "mag_z = -375.6 uT",
     [](VectorSeries& s) { return each(s, 67, [](Vector3& v) { v[2] = -375.6; }); }},
    {"a_range_that_turns_over", "gyr", "wrap", "gyr_x",
     [](VectorSeries& s) { return wrap(s, 0, 1.3); }},
    {"a_range_that_turns_over_from_the_first_sample_on", "acc", "wrap", "acc_z",
     [](VectorSeries& s) { return wrap(s, 2, 8.0); }},
    {"clipped", "gyr", "clipped", "gyr_x = 1.3 rad/s",
     [](VectorSeries& s) {
       std::set<std::size_t> out;
       for (std::size_t k = 0; k < s.size(); ++k) {
         if (s.v[k][0] > 1.3) out.insert(k);
         s.v[k][0] = std::min(s.v[k][0], 1.3);
       }
       return out;
     }},
    // A few readings, at the end that another axis shows.
    {"clipped_where_another_axis_is", "gyr", "clipped", "rad/s",
     [](VectorSeries& s) {
       std::set<std::size_t> out;
       for (std::size_t k = 0; k < s.size(); ++k) {
         if (s.v[k][0] > 1.3) out.insert(k);
         s.v[k][0] = std::min(s.v[k][0], 1.3);
         s.v[k][1] = std::max(s.v[k][1], -1.25);
         if (k >= 3000 && k < 3004) {
           s.v[k][1] = -1.3;
           out.insert(k);
         }
       }
       return out;
     }},
};

class Gate : public testing::TestWithParam<Fault> {};

TEST_P(Gate, sets_aside_what_was_not_measured_and_says_so) {
  const Fault& fault = GetParam();
  Recording r = turning();
  const std::set<std::size_t> bad = fault.spoil(series_of(r, fault.sensor));
  const VectorSeries spoilt = series_of(r, fault.sensor);
  ASSERT_FALSE(bad.empty());
  std::optional<Recording> kept = gated(r);
  ASSERT_TRUE(kept);
  std::size_t found = 0;
  std::string all;
  for (const SetAside& s : kept->set_aside) {
    EXPECT_EQ(s.sensor, fault.sensor);
    EXPECT_EQ(s.of, spoilt.size());
    EXPECT_THAT(sentence(s), HasSubstr(s.example));
    EXPECT_FALSE(remedy(s).empty());
    all += sentence(s) + "\n";
    if (s.kind == fault.kind) {
      found += s.count;
      EXPECT_THAT(s.example, HasSubstr(fault.example));
    }
  }
  // A wrapped reading may be told as an isolated jump.
  EXPECT_GE(double(found), 0.97 * double(bad.size())) << all;
  const VectorSeries& left = series_of(*kept, fault.sensor);
  std::size_t wrong = 0, lost = 0;
  for (std::size_t k = 0, i = 0; k < spoilt.size(); ++k) {
    while (i < left.size() && left.t[i] < spoilt.t[k]) ++i;
    const bool there = i < left.size() && left.t[i] == spoilt.t[k] && left.v[i] == spoilt.v[k];
    wrong += there && bad.contains(k) ? 1 : 0;
    lost += !there && !bad.contains(k) ? 1 : 0;
  }
  EXPECT_LE(double(wrong), 0.02 * double(bad.size())) << all;
  EXPECT_EQ(lost, 0u) << all;
  // Said once, and the checks of what is left find nothing but that it may end early.
  for (const Issue& issue : check_recording(*kept)) {
    EXPECT_TRUE(issue.kind == "set_aside" || issue.kind == "span") << issue.text();
  }
}

// As a stream of samples; what passes.
Recording streamed(const Recording& r, std::vector<SetAside>& set_aside) {
  LiveGate gate(r.mag_names);
  Recording out;
  out.mag.resize(1);
  const auto take = [&] {
    const LiveGate::Kept kept = gate.take();
    const auto add = [](VectorSeries& to, const VectorSeries& from) {
      for (std::size_t k = 0; k < from.size(); ++k) to.push_back(from.t[k], from.v[k]);
    };
    add(out.acc, kept.acc);
    add(out.gyr, kept.gyr);
    add(out.mag[0], kept.mag[0]);
  };
  std::size_t a = 0, g = 0, m = 0;
  while (a < r.acc.size() || g < r.gyr.size() || m < r.mag[0].size()) {
    StreamSample sample;
    const auto next = [](const VectorSeries& s, std::size_t k) {
      return k < s.size() ? s.t[k] : INFINITY;
    };
    sample.t = std::min({next(r.acc, a), next(r.gyr, g), next(r.mag[0], m)});
    sample.mag.resize(1);
    if (next(r.acc, a) == sample.t) sample.acc = r.acc.v[a++];
    if (next(r.gyr, g) == sample.t) sample.gyr = r.gyr.v[g++];
    if (next(r.mag[0], m) == sample.t) sample.mag[0] = r.mag[0].v[m++];
    gate.push(sample);
    take();
  }
  gate.finish();
  take();
  set_aside = gate.set_aside();
  return out;
}

// It cannot look back: of a value that comes again and again it learns what it is, a range that
// turned over for long, or was clipped before anybody knew its limit, passes.
TEST_P(Gate, of_a_stream_sets_aside_the_same_but_for_what_only_the_whole_tells) {
  const Fault& fault = GetParam();
  Recording r = turning();
  const std::set<std::size_t> bad = fault.spoil(series_of(r, fault.sensor));
  std::vector<SetAside> set_aside;
  Recording kept = streamed(r, set_aside);
  const VectorSeries &spoilt = series_of(r, fault.sensor), &left = series_of(kept, fault.sensor);
  std::size_t wrong = 0, lost = 0;
  for (std::size_t k = 0, i = 0; k < spoilt.size(); ++k) {
    while (i < left.size() && left.t[i] < spoilt.t[k]) ++i;
    const bool there = i < left.size() && left.t[i] == spoilt.t[k];
    wrong += there && bad.contains(k) ? 1 : 0;
    lost += !there && !bad.contains(k) ? 1 : 0;
  }
  EXPECT_LE(double(wrong),
            (fault.kind == "wrap" || fault.kind == "clipped" ? 0.9 : 0.1) * double(bad.size()));
  EXPECT_LE(lost, fault.kind == "wrap" ? bad.size() : 0u);
  ASSERT_FALSE(set_aside.empty());
  for (const SetAside& s : set_aside) EXPECT_EQ(s.sensor, fault.sensor);
}

TEST(LiveGate, leaves_a_good_recording_as_it_is_and_is_soon_through_with_it) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::vector<SetAside> set_aside;
    const Recording r = turning(seed);
    const Recording kept = streamed(r, set_aside);
    EXPECT_TRUE(set_aside.empty());
    EXPECT_EQ(kept.acc.size(), r.acc.size());
    EXPECT_EQ(kept.gyr.v, r.gyr.v);
    EXPECT_EQ(kept.mag[0].t, r.mag[0].t);
  }
}

TEST(LiveGate, does_not_wait_for_a_sensor_that_has_fallen_silent) {
  LiveGate gate({"mag"});
  const Recording r = turning();
  double behind = 0.0;
  for (std::size_t k = 0; k < r.acc.size(); ++k) {
    StreamSample sample{r.acc.t[k], r.acc.v[k], r.gyr.v[k], {std::nullopt}};
    if (k < 1000) sample.mag[0] = r.mag[0].v[k];
    gate.push(sample);
    if (sample.t < 5.0) continue;  // the first seconds are held back
    double judged = sample.t;
    while (!gate.has_judged(judged)) judged -= 0.01;
    behind = std::max(behind, sample.t - judged);
  }
  EXPECT_LT(behind, 2.2);
}

INSTANTIATE_TEST_SUITE_P(Of, Gate, testing::ValuesIn(kFaults),
                         [](const auto& fault) { return fault.param.name; });

TEST(GateForFiles, leaves_a_good_recording_as_it_is) {
  for (unsigned seed = 1; seed <= 5; ++seed) EXPECT_FALSE(gated(turning(seed)));
}

TEST(GateForFiles, replaces_a_lost_gyroscope_sample_by_what_its_neighbours_say) {
  Recording r = turning();
  const Vector3 measured = r.gyr.v[3600];
  r.gyr.v[3600][1] = kNaN;
  r.gyr.v[3601][1] = kNaN;
  const std::optional<Recording> kept = gated(r);
  ASSERT_TRUE(kept);
  ASSERT_EQ(kept->gyr.size(), r.gyr.size());
  // Four samples with noise of 0.005 rad/s, weights up to 2/3.
  EXPECT_LT((kept->gyr.v[3600] - measured).norm(), 0.04);
  r.gyr.v[3602][1] = r.gyr.v[3603][1] = kNaN;
  EXPECT_EQ(gated(r)->gyr.size(), r.gyr.size() - 4);  // nobody knows how it turned meanwhile
}

TEST(GateForFiles, fills_a_hole_that_a_logger_left_in_a_gyroscope_with_a_steady_clock) {
  const Recording whole = turning();
  Recording r = whole;
  for (const std::size_t k : {5000, 3001, 3000}) {
    r.gyr.t.erase(r.gyr.t.begin() + long(k));
    r.gyr.v.erase(r.gyr.v.begin() + long(k));
  }
  const std::optional<Recording> kept = gated(r);
  ASSERT_TRUE(kept);
  EXPECT_TRUE(kept->set_aside.empty());
  ASSERT_EQ(kept->gyr.size(), whole.gyr.size());
  for (const std::size_t k : {3000, 3001, 5000}) {
    EXPECT_NEAR(kept->gyr.t[k], whole.gyr.t[k], 1e-9);
    EXPECT_LT((kept->gyr.v[k] - whole.gyr.v[k]).norm(), 0.04);
  }
}

TEST(GateForFiles, sets_aside_what_was_clipped_once_for_long) {
  Recording r = turning();
  std::size_t clipped = 0;
  for (std::size_t k = 2900; k < 3100; ++k) {
    double& rate = r.gyr.v[k][1];
    rate -= 6.0 * std::exp(-0.5 * std::pow((double(k) - 3000.0) / 25.0, 2));
    clipped += rate < -3.0;
    rate = std::max(rate, -3.0);
  }
  const std::optional<Recording> kept = gated(r);
  ASSERT_TRUE(kept);
  ASSERT_EQ(kept->set_aside.size(), 1u);
  EXPECT_EQ(kept->set_aside[0].kind, "clipped");
  EXPECT_EQ(kept->set_aside[0].count, clipped);
}

// One swing beyond the range on each of two axes, at opposite ends, with noise of many steps.
TEST(GateForFiles, sets_aside_what_was_clipped_once_on_each_of_two_axes) {
  Recording r = turning();
  std::size_t clipped = 0;
  for (std::size_t k = 1900; k < 3100; ++k) {
    const auto swing = [&](double middle) {
      return 6.0 * std::exp(-0.5 * std::pow((double(k) - middle) / 8.0, 2));
    };
    Vector3& rate = r.gyr.v[k];
    rate.x() += swing(2000.0);
    rate.y() -= swing(3000.0);
    clipped += rate.x() > 3.0 || rate.y() < -3.0;
    rate.x() = std::min(rate.x(), 3.0);
    rate.y() = std::max(rate.y(), -3.0);
  }
  const std::optional<Recording> kept = gated(r);
  ASSERT_TRUE(kept);
  ASSERT_EQ(kept->set_aside.size(), 1u);
  EXPECT_EQ(kept->set_aside[0].kind, "clipped");
  EXPECT_EQ(kept->set_aside[0].count, clipped);
}

TEST(GateForFiles, a_sensor_of_garbage_stays_and_is_refused) {
  Recording r = turning();
  for (std::size_t k = 0; k < r.mag[0].size(); ++k)
    r.mag[0].v[k].setConstant(1e20 + 1e15 * double(k));
  const std::optional<Recording> kept = gated(r);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->mag[0].size(), r.mag[0].size());
  const std::vector<Issue> issues = check_recording(*kept);
  ASSERT_FALSE(issues.empty());
  EXPECT_EQ(issues[0].severity, Severity::kFatal);
  EXPECT_THAT(issues[0].problem, HasSubstr("100 % of the samples of mag"));
}

TEST(GateForFiles, most_of_a_sensor_gone_is_fatal_and_zeros_between_samples_are_not) {
  Recording r = turning(), slow = turning();
  for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
    if (k % 3 != 0) r.mag[0].v[k][0] = kNaN;
    if (k % 4 != 0) slow.mag[0].v[k].setZero();
  }
  EXPECT_EQ(check_recording(*gated(r)).front().severity, Severity::kFatal);
  const std::optional<Recording> kept = gated(slow);
  EXPECT_EQ(kept->mag[0].size(), slow.mag[0].size() / 4);
  EXPECT_EQ(check_recording(*kept).front().severity, Severity::kNote);
}

TEST(GateForFiles, may_keep_clipped_readings_of_magnetometers_for_a_diagnosis) {
  Recording r = turning();
  for (Vector3& v : r.mag[0].v) v[0] = std::min(v[0], 30.0);
  ASSERT_TRUE(gated(r));
  EXPECT_EQ(gated(r)->set_aside.front().kind, "clipped");
  EXPECT_FALSE(gated(r, {.keep_clipped_mag = true}));
}

// Any counts within the range that the sensor was seen to use, as a transfer that failed gives
// them, in a few samples: all but those that happen to be near, and nothing else.
TEST(Gate, garbage_within_the_range_is_set_aside) {
  const struct {
    const char* sensor;
    double range, near;
  } kCases[] = {{"acc", 10.0, 3.0}, {"gyr", 2.0, 0.3}, {"mag", 50.0, 6.0}};
  for (const auto& c : kCases) {
    for (const std::size_t count : {1U, 3U, 12U}) {
      for (unsigned seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE(fmt::format("{} {} {}", c.sensor, count, seed));
        Recording r = turning(20 + seed);
        std::mt19937 bits(seed);
        std::uniform_real_distribution<double> any(-c.range, c.range);
        VectorSeries& s = series_of(r, c.sensor);
        std::set<std::size_t> bad;
        std::size_t far = 0;
        while (bad.size() < count) {
          const std::size_t k = 20 + bits() % (s.size() - 40);
          if (!bad.insert(k).second) continue;
          const Vector3 before = s.v[k];
          s.v[k] = Vector3(any(bits), any(bits), any(bits));
          far += (s.v[k] - before).cwiseAbs().maxCoeff() > c.near ? 1 : 0;
        }
        std::size_t found = 0;
        if (const auto kept = gated(r)) {
          for (const SetAside& of : kept->set_aside) {
            EXPECT_EQ(of.sensor, c.sensor);
            found += of.count;
          }
        }
        // Of many a small one may be of a tail.
        EXPECT_GE(found + far / 10, far);
        EXPECT_LE(found, bad.size());
      }
    }
  }
}

// 42 uT is what this field may well be on this axis, at another time.
TEST(Gate, one_value_of_a_driver_within_the_range_is_set_aside) {
  Recording r = turning(9);
  for (const std::size_t k : {700U, 2500U, 4100U}) r.mag[0].v[k].setConstant(42.0);
  const auto kept = gated(r);
  ASSERT_TRUE(kept);
  ASSERT_EQ(kept->set_aside.size(), 1u);
  EXPECT_EQ(kept->set_aside[0].count, 3u);
  EXPECT_THAT(sentence(kept->set_aside[0]), HasSubstr("= 42 uT at 7.00 s"));
}

// It resumes where it hung: the device hardly moved. Its noise should have moved it, unless it is
// too coarse for that.
TEST(Gate, a_sensor_that_hangs_at_rest_and_goes_on_is_set_aside_if_its_noise_would_show) {
  for (const std::string sensor : {"acc", "gyr", "mag"}) {
    SCOPED_TRACE(sensor);
    Recording r = turning(4);
    hold(series_of(r, sensor), 200, 240);
    const auto kept = gated(r);
    ASSERT_TRUE(kept);
    ASSERT_EQ(kept->set_aside.size(), 1u);
    EXPECT_EQ(kept->set_aside[0].sensor, sensor);
    EXPECT_EQ(kept->set_aside[0].kind, "stuck");
    EXPECT_EQ(kept->set_aside[0].count, 39u);
    Recording coarse = turning(4);
    const double step = sensor == "acc" ? 0.2 : sensor == "gyr" ? 0.03 : 2.0;
    round_to(series_of(coarse, sensor), step);
    EXPECT_FALSE(gated(coarse));
  }
}

// Sample by sample, as they arrive.
TEST(GateForStreams, judges_each_sample_after_a_few_more_and_in_order) {
  Recording r = turning();
  VectorSeries& mag = r.mag[0];
  mag.v[3000][1] = 900.0;
  mag.v[3300] = Vector3(1e20, 0, 0);
  mag.v[3500][0] = kNaN;
  mag.v[4000].setZero();
  SensorGate gate({.sensor = Sensor::kMag});
  std::vector<double> times, bad;
  std::size_t behind = 0;
  for (std::size_t k = 0; k < mag.size(); ++k) {
    gate.push(mag.t[k], mag.v[k]);
    for (const SensorGate::Judged& s : gate.take()) {
      times.push_back(s.t);
      if (!s.kind.empty()) bad.push_back(s.t);
    }
    behind = std::max(behind, k + 1 - times.size());
  }
  EXPECT_LE(behind, 9u);
  gate.finish();
  for (const SensorGate::Judged& s : gate.take()) times.push_back(s.t);
  EXPECT_EQ(times, mag.t);
  EXPECT_THAT(bad, ElementsAre(30.0, 33.0, 35.0, 40.0));
}

// Nothing follows to show it, and nothing turned: its own noise is missing, while others have
// theirs. Where none has, as in a simulated rest, none hangs.
TEST(Gate, a_sensor_that_hangs_while_the_device_rests_to_the_end_is_set_aside) {
  Recording at_rest = turning();
  std::mt19937 bits(3);
  std::normal_distribution<double> noise;
  const auto random = [&] { return Vector3(noise(bits), noise(bits), noise(bits)); };
  for (std::size_t k = 5500; k < 6500; ++k) {
    at_rest.acc.v[k] = at_rest.acc.v[5499] + 0.03 * random();
    at_rest.gyr.v[k] = 0.005 * random();
    at_rest.mag[0].v[k] = at_rest.mag[0].v[5499] + 0.3 * random();
  }
  EXPECT_FALSE(gated(at_rest));
  for (const std::string sensor : {"acc", "gyr", "mag"}) {
    Recording r = at_rest;
    hold(series_of(r, sensor), 5600, 6500);
    const auto kept = gated(r);
    ASSERT_TRUE(kept) << sensor;
    ASSERT_EQ(kept->set_aside.size(), 1u) << sensor;
    EXPECT_EQ(kept->set_aside[0].sensor, sensor);
    EXPECT_EQ(kept->set_aside[0].kind, "stuck");
    EXPECT_EQ(kept->set_aside[0].count, 899u);
  }
  Recording r = at_rest;
  for (const std::string sensor : {"acc", "gyr", "mag"}) hold(series_of(r, sensor), 5600, 6500);
  EXPECT_FALSE(gated(r));
}

TEST(GateForStreams, goes_on_when_a_sensor_hangs) {
  Recording r = turning();
  hold(r.mag[0], 2000, 6500);
  SensorGate gate({.sensor = Sensor::kMag,
                   .longest_wait_s = 1.0,
                   .turned = [](double begin, double end) { return end - begin > 0.5; }});
  std::size_t judged = 0, stuck = 0, behind = 0;
  for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
    gate.push(r.mag[0].t[k], r.mag[0].v[k]);
    for (const SensorGate::Judged& s : gate.take()) {
      ++judged;
      stuck += s.kind == "stuck" ? 1 : 0;
    }
    behind = std::max(behind, k + 1 - judged);
  }
  EXPECT_LE(behind, 110u);
  EXPECT_GT(stuck, 4200u);
}

// Its bits repeat three times in a row here and there, which no measurement does.
TEST(RealRecordings, lose_nothing_in_the_gate_but_samples_that_were_filled_in) {
  const std::filesystem::path folder = std::filesystem::path(MAGIMU_DATA_DIR) / "broad";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the BROAD recordings are not there";
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".hdf5" && file.path().extension() != ".mat") continue;
    SCOPED_TRACE(file.path().filename());
    const std::optional<Recording> kept = gated(read_recording(file.path().string()));
    if (!kept) continue;
    for (const SetAside& s : kept->set_aside) {
      EXPECT_EQ(s.kind, "stuck") << sentence(s);
      EXPECT_LE(s.count, 12u) << sentence(s);
    }
  }
}

}  // namespace
}  // namespace magimu
