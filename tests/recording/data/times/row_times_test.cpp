// SPDX-License-Identifier: BSD-3-Clause
// Time columns as loggers write them, and what the reader makes of them.
#include "recording/data/times/row_times.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "recording/csv/csv.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kTimedHeader = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";

// A row with all sensors, whose numbers tell which one it is.
std::string timed_row(const std::string& time, int k) {
  return fmt::format("{0},{1},2,3,{1},5,6,{1},8,9\n", time, k);
}

// Rows k = 0, 1, ... with these times.
std::string timed_rows(int count, const std::function<double(int)>& time) {
  std::string out = kTimedHeader;
  for (int k = 0; k < count; ++k) out += timed_row(fmt::format("{:.12g}", time(k)), k);
  return out;
}
std::string counted_rows(int count, const std::function<long long(int)>& time) {
  std::string out = kTimedHeader;
  for (int k = 0; k < count; ++k) out += timed_row(fmt::format("{}", time(k)), k);
  return out;
}

Recording read_log(const std::string& content, const CsvOptions& options = {}) {
  return csv_recording(content, "log.csv", options);
}
InputError refusal(const std::string& content, const CsvOptions& options = {}) {
  return test::error_of([&] { read_log(content, options); });
}
double longest_step(const std::vector<double>& t) {
  double out = 0.0;
  for (std::size_t k = 1; k < t.size(); ++k) out = std::max(out, t[k] - t[k - 1]);
  return out;
}
bool increases(const std::vector<double>& t) {
  return std::ranges::adjacent_find(t, std::greater_equal<>()) == t.end();
}

TEST(TimeUnits, since_1970_are_recognised_and_count_from_the_first_row) {
  for (const long long unit : {1000LL, 1000000LL, 1000000000LL}) {
    SCOPED_TRACE(unit);
    const Recording r =
        read_log(counted_rows(45, [=](int k) { return 1700000000 * unit + k * unit / 25; }));
    EXPECT_EQ(r.gyr.t.front(), 0.0);
    EXPECT_NEAR(r.gyr.rate_hz(), 25.0, 1e-3);
    EXPECT_THAT(r.notes, Contains(HasSubstr("since 1970")));
    EXPECT_THAT(r.cautions, IsEmpty());
  }
}

TEST(TimeUnits, seconds_since_1970_count_from_the_first_row_too) {
  std::string content = kTimedHeader;
  for (int k = 0; k < 100; ++k) content += timed_row(fmt::format("1700000000.{:02}", k), k);
  const Recording r = read_log(content);
  EXPECT_EQ(r.gyr.t.front(), 0.0);
  EXPECT_NEAR(r.gyr.t.back(), 0.99, 1e-6);
}

TEST(TimeUnits, since_boot_are_recognised_by_the_pace_of_the_rows) {
  EXPECT_NEAR(read_log(counted_rows(50, [](int k) { return 12345 + 20 * k; })).gyr.rate_hz(), 50.0,
              1e-9);
  EXPECT_NEAR(read_log(counted_rows(50, [](int k) { return 12345678 + 5000 * k; })).gyr.rate_hz(),
              200.0, 1e-9);
  EXPECT_NEAR(
      read_log(counted_rows(50, [](int k) { return 123456789LL + 5000000LL * k; })).gyr.rate_hz(),
      200.0, 1e-9);
}

TEST(TimeUnits, are_those_of_the_pace_where_rows_come_in_bursts_or_with_gaps) {
  // 20 at a time, 0.3 ms apart, in ns; and a gap of an hour in us.
  const Recording bursts = read_log(counted_rows(
      400, [](int k) { return 1000LL * (20000 * (k - k % 20 + 19) + 300 * (k % 20)); }));
  EXPECT_NEAR(bursts.gyr.rate_hz(), 50.0, 0.2);
  const Recording gap =
      read_log(counted_rows(60, [](int k) { return 5000LL * k + (k < 30 ? 0LL : 3600000000LL); }));
  EXPECT_NEAR(gap.gyr.rate_hz(), 200.0, 1e-6);
}

TEST(TimeUnits, that_are_ambiguous_are_refused_with_both_options) {
  const InputError error =
      refusal(counted_rows(50, [](int k) { return 250 * k; }));  // 4 Hz or 4 kHz
  EXPECT_THAT(error.problem, HasSubstr("4 Hz if it is in ms, 4000 Hz if it is in us"));
  EXPECT_THAT(error.remedy, HasSubstr("--unit t=us"));
  CsvOptions options;
  options.time_unit = 1e-6;
  EXPECT_NEAR(read_log(counted_rows(50, [](int k) { return 250 * k; }), options).gyr.rate_hz(),
              4000.0, 1e-6);
}

TEST(TimeUnits, seconds_stay_seconds) {
  for (const double h : {1.0 / 8000.0, 0.01, 0.1, 0.9}) {
    const Recording r = read_log(timed_rows(60, [=](int k) { return 3.0 + h * k; }));
    EXPECT_NEAR(r.gyr.t.back(), 3.0 + 59 * h, 1e-9);
    EXPECT_THAT(r.notes, Not(Contains(HasSubstr("is read as"))));
  }
}

TEST(Counter, of_samples_is_no_time_and_the_rate_makes_it_one) {
  const std::string content = counted_rows(45, [](int k) { return k < 30 ? k : k + 2; });
  const InputError error = refusal(content);
  EXPECT_THAT(error.problem, HasSubstr("counts samples"));
  EXPECT_THAT(error.remedy, HasSubstr("--rate HZ"));
  CsvOptions options;
  options.rate_hz = 50.0;
  const Recording r = read_log(content, options);
  EXPECT_NEAR(r.gyr.t[29], 29.0 / 50.0, 1e-12);
  EXPECT_NEAR(r.gyr.t[30], 32.0 / 50.0, 1e-12);  // lost samples stay lost
}

TEST(Counter, is_not_seen_where_the_unit_is_given_or_named) {
  CsvOptions options;
  options.time_unit = 1e-3;
  EXPECT_NEAR(read_log(counted_rows(45, [](int k) { return k; }), options).gyr.rate_hz(), 1000.0,
              1e-6);
  std::string content = counted_rows(45, [](int k) { return k; });
  content.replace(0, 1, "time (ms)");
  EXPECT_NEAR(read_log(content).gyr.rate_hz(), 1000.0, 1e-6);
}

TEST(Rate, serves_a_file_without_times) {
  std::string content = kTimedHeader.substr(2);
  for (int k = 0; k < 30; ++k) content += "1,2,3,4,5,6,7,8,9\n";  // equal rows are no repeats here
  EXPECT_THAT(refusal(content).remedy, HasSubstr("--rate HZ"));
  CsvOptions options;
  options.rate_hz = 100.0;
  const Recording r = read_log(content, options);
  EXPECT_EQ(r.acc.size(), 30U);
  EXPECT_NEAR(r.acc.t.back(), 0.29, 1e-12);
}

TEST(NoNumber, means_no_sample_of_that_sensor) {
  std::string content = kTimedHeader + timed_row("0", 0);
  for (const char* none : {"nan", "NaN", "-nan", "NA", "null", "None", "inf", "-Infinity"}) {
    content += fmt::format("{},1,2,3,4,5,6,{},8,9\n", 0.01 * double(content.size()), none);
  }
  const Recording r = read_log(content);
  EXPECT_EQ(r.gyr.size(), 9U);
  EXPECT_EQ(r.mag.at(0).size(), 1U);
  EXPECT_THAT(r.notes, Contains(HasSubstr(": 8, the first in line 3, 2 of them infinite")));
}

TEST(RowsOfOneTime, with_different_sensors_are_one) {
  std::string content = kTimedHeader;
  for (int k = 0; k < 40; ++k) {
    content += fmt::format("{0},{1},2,3,{1},5,6,,,\n{0},,,,,,,{1},8,9\n", 0.04 * k, k);
  }
  const Recording r = read_log(content);
  EXPECT_EQ(r.gyr.size(), 40U);
  EXPECT_EQ(r.mag.at(0).t, r.gyr.t);
  EXPECT_THAT(r.cautions, IsEmpty());
}

TEST(RowsOfOneTime, that_repeat_time_and_readings_are_dropped_and_counted) {
  std::string content = kTimedHeader;
  for (int k = 0; k < 40; ++k) {
    content += timed_row(fmt::format("{}", 0.04 * k), k);
    if (k % 10 == 3) content += timed_row(fmt::format("{}", 0.04 * k), k);
  }
  const Recording r = read_log(content);
  EXPECT_EQ(r.gyr.size(), 40U);
  EXPECT_THAT(r.notes, Contains(HasSubstr("time and readings: 4, the first in line 6")));
}

TEST(RowsOfOneTime, with_other_readings_lose_them_with_a_caution_where_they_are_few) {
  const Recording r = read_log(timed_rows(100, [](int k) { return 0.01 * (k == 50 ? 49 : k); }));
  EXPECT_EQ(r.gyr.size(), 99U);
  EXPECT_EQ(r.gyr.v[49][0], 49.0);
  EXPECT_THAT(r.cautions, ElementsAre(HasSubstr("other readings: 1, the first in line 52")));
}

TEST(RowsOfOneTime, with_other_readings_are_refused_where_they_are_many) {
  // Faster and faster: no steady pace that could be restored.
  const auto time = [](int k) { return 0.01 * std::floor(0.0065 * k * k); };
  EXPECT_THAT(refusal(timed_rows(100, time)).problem, HasSubstr("other readings: 39"));
}

// Now and then two at a time, and none at the next: a steady pace, whose stamps are off by a step.
TEST(RowsOfOneTime, are_evened_where_the_pace_is_steady_to_a_step) {
  const Recording r =
      read_log(timed_rows(100, [](int k) { return 0.01 * (k % 7 == 3 ? k - 1 : k); }));
  ASSERT_EQ(r.gyr.size(), 100U);
  EXPECT_THAT(r.cautions, ElementsAre(HasSubstr("each within a step")));
  for (std::size_t k = 0; k < 100; ++k) {
    EXPECT_NEAR(r.gyr.t[k] - r.gyr.t[0], 0.01 * double(k), 0.002);
  }
}

TEST(ClockSetBack, begins_a_part_ten_seconds_later) {
  const Recording r =
      read_log(timed_rows(200, [](int k) { return k < 120 ? 5.0 + 0.01 * k : 0.01 * (k - 120); }));
  EXPECT_TRUE(increases(r.gyr.t));
  EXPECT_EQ(r.gyr.size(), 200U);
  EXPECT_NEAR(r.gyr.t[120] - r.gyr.t[119], kPartGap, 1e-9);
  EXPECT_NEAR(r.gyr.t[199] - r.gyr.t[120], 0.79, 1e-9);
  EXPECT_THAT(r.cautions, ElementsAre(HasSubstr("set back at line 122 (t 6.19 -> 0 s)")));
  EXPECT_EQ(r.mag.at(0).t, r.gyr.t);
}

TEST(ClockSetBack, with_a_header_line_above_is_one_part_more_as_well) {
  std::string content = timed_rows(100, [](int k) { return 0.01 * k; });
  content += timed_rows(100, [](int k) { return 0.01 * k; });
  const Recording r = read_log(content);
  EXPECT_EQ(r.gyr.size(), 200U);
  EXPECT_NEAR(longest_step(r.gyr.t), kPartGap, 1e-9);
  EXPECT_THAT(r.notes, Contains(HasSubstr("header lines within the rows: 1")));
}

TEST(ClockSetBack, is_not_seen_in_a_header_that_is_only_repeated) {
  std::string content = timed_rows(100, [](int k) { return 0.01 * k; });
  content += timed_rows(100, [](int k) { return 1.0 + 0.01 * k; });
  const Recording r = read_log(content);
  EXPECT_NEAR(longest_step(r.gyr.t), 0.01, 1e-9);
  EXPECT_THAT(r.cautions, IsEmpty());
}

TEST(ClockSetForward, by_years_begins_a_part_and_keeps_times_small) {
  const Recording r =
      read_log(timed_rows(200, [](int k) { return 0.01 * k + (k < 100 ? 0.0 : 1.7e9); }));
  EXPECT_LT(r.gyr.t.back(), 20.0);
  EXPECT_THAT(r.cautions, ElementsAre(HasSubstr("set forward at line 102")));
}

TEST(Gap, of_a_day_stays_as_it_is) {
  const Recording r =
      read_log(timed_rows(200, [](int k) { return 0.01 * k + (k < 100 ? 0.0 : 86400.0); }));
  EXPECT_NEAR(longest_step(r.gyr.t), 86400.01, 1e-6);
  EXPECT_THAT(r.cautions, IsEmpty());
}

TEST(Rollover, of_a_counter_goes_on_without_a_gap) {
  const long long wrap = 1LL << 32;
  const Recording us =
      read_log(counted_rows(400, [=](int k) { return (wrap - 1000000 + 10000LL * k) % wrap; }));
  EXPECT_NEAR(longest_step(us.gyr.t), 0.01, 1e-6);
  EXPECT_THAT(us.notes, Contains(HasSubstr("rolled over at line 102")));
  EXPECT_THAT(us.cautions, IsEmpty());
  const Recording ms =
      read_log(counted_rows(400, [=](int k) { return (wrap - 1000 + 10LL * k) % wrap; }));
  EXPECT_NEAR(longest_step(ms.gyr.t), 0.01, 1e-6);
  const Recording s =
      read_log(timed_rows(400, [](int k) { return std::fmod(4290.0 + 0.02 * k, 4294.967296); }));
  EXPECT_NEAR(longest_step(s.gyr.t), 0.02, 1e-6);
  const Recording day =
      read_log(timed_rows(400, [](int k) { return std::fmod(86399.0 + 0.01 * k, 86400.0); }));
  EXPECT_NEAR(longest_step(day.gyr.t), 0.01, 1e-6);
}

TEST(OutOfOrder, rows_are_put_in_the_order_of_time) {
  // Neighbours swapped here and there.
  const auto time = [](int k) { return 0.01 * (k % 20 == 7 ? k + 1 : k % 20 == 8 ? k - 1 : k); };
  const Recording r = read_log(timed_rows(200, time));
  EXPECT_EQ(r.gyr.size(), 200U);
  EXPECT_TRUE(increases(r.gyr.t));
  EXPECT_EQ(r.gyr.v[8][0], 7.0);
  EXPECT_THAT(r.cautions, IsEmpty());
  EXPECT_THAT(r.notes, Contains(HasSubstr("in the order of time: 10")));
}

TEST(OutOfOrder, sensors_may_come_one_after_another) {
  std::string content = kTimedHeader;
  for (int k = 0; k < 100; ++k) content += fmt::format("{},{},2,3,,,,,,\n", 0.01 * k, k);
  for (int k = 0; k < 100; ++k) content += fmt::format("{},,,,{},2,3,,,\n", 0.01 * k, k);
  for (int k = 0; k < 50; ++k) content += fmt::format("{},,,,,,,{},2,3\n", 0.02 * k, k);
  const Recording r = read_log(content);
  EXPECT_EQ(r.gyr.t, r.acc.t);
  EXPECT_NEAR(r.mag.at(0).t.back(), 0.98, 1e-12);
  EXPECT_THAT(r.cautions, IsEmpty());
}

TEST(OutOfOrder, a_damaged_time_costs_its_row) {
  for (const double wrong : {0.0, 99999.0, 7.3e9, -1.0}) {
    SCOPED_TRACE(wrong);
    const Recording r =
        read_log(timed_rows(300, [=](int k) { return k == 200 ? wrong : 5.0 + 0.01 * k; }));
    EXPECT_EQ(r.gyr.size(), 299U);
    EXPECT_NEAR(longest_step(r.gyr.t), 0.02, 1e-9);
    EXPECT_THAT(r.cautions, ElementsAre(HasSubstr("damaged time: 1, the first in line 202")));
  }
}

TEST(OutOfOrder, times_without_any_order_are_refused) {
  const InputError error = refusal(timed_rows(300, [](int k) { return 10.0 - 0.01 * k; }));
  EXPECT_THAT(error.problem, HasSubstr("does not increase"));
  EXPECT_THAT(error.remedy, HasSubstr("sort the rows"));
  EXPECT_GT(error.line, 0);
}

TEST(ArrivalStamps, in_bursts_become_even_times) {
  for (const int together : {2, 4, 10, 32}) {
    SCOPED_TRACE(together);
    const auto time = [=](int k) {
      const int in = k % together;
      return 0.01 * (k - in + together - 1) + 0.0002 * in;
    };
    const Recording r = read_log(timed_rows(32 * 40, time));
    EXPECT_NEAR(r.gyr.rate_hz(), 100.0, 0.1);
    EXPECT_NEAR(longest_step(r.gyr.t), 0.01, 1e-4);
    for (std::size_t k = 0; k < r.gyr.size(); ++k) {
      ASSERT_NEAR(r.gyr.t[k], 0.01 * double(k), 0.0002 * together + 1e-3) << k;
    }
    EXPECT_THAT(r.cautions, ElementsAre(HasSubstr("stamped on arrival")));
  }
}

TEST(ArrivalStamps, of_varying_bursts_and_with_one_lost_keep_the_gap) {
  // Three to five at a time, at the queue's whim; 60 samples are lost in the middle.
  std::string content = kTimedHeader;
  int k = 0;
  for (int burst = 0; burst < 120; ++burst) {
    if (burst == 60) k += 60;
    const int together = 3 + (burst * 7) % 3;
    for (int in = 0; in < together; ++in) {
      content += timed_row(fmt::format("{:.6f}", 0.01 * (k + together - 1) + 0.0003 * in), k + in);
    }
    k += together;
  }
  const Recording r = read_log(content);
  EXPECT_NEAR(r.gyr.rate_hz(), 100.0, 0.5);
  EXPECT_NEAR(longest_step(r.gyr.t), 0.61, 0.02);
  for (std::size_t i = 0; i < r.gyr.size(); ++i) {
    ASSERT_NEAR(r.gyr.t[i], 0.01 * r.gyr.v[i][0], 0.02) << i;
  }
}

TEST(ArrivalStamps, that_are_equal_within_a_burst_are_spread_as_well) {
  const Recording r = read_log(timed_rows(400, [](int k) { return 0.02 * (k / 4); }));
  EXPECT_EQ(r.gyr.size(), 400U);
  EXPECT_NEAR(r.gyr.rate_hz(), 200.0, 0.5);
}

// A host reads 1000 samples a second when it gets round to it: each is late by itself, two
// milliseconds on average, and those behind it wait.
TEST(ArrivalStamps, that_are_late_by_chance_become_even_times) {
  constexpr double kInterval = 1e-3, kLate = 2e-3;
  std::mt19937_64 random(7);
  std::exponential_distribution<double> late(1.0 / kLate);
  double last = -1.0;
  const Recording r = read_log(timed_rows(
      20000, [&](int k) { return last = std::max(last + 1e-6, kInterval * k + late(random)); }));
  EXPECT_THAT(r.cautions, ElementsAre(HasSubstr("stamped on arrival")));
  EXPECT_NEAR(r.gyr.rate_hz(), 1000.0, 0.1);
  const double behind = r.gyr.t[10000] - 10.0;
  for (std::size_t k = 0; k < r.gyr.size(); ++k) {
    ASSERT_NEAR(r.gyr.t[k] - behind, kInterval * r.gyr.v[k][0], 1e-3) << k;
  }
}

// Samples that were measured when it pleased, several at once.
TEST(ArrivalStamps, of_samples_without_a_pace_stay_as_they_are) {
  std::mt19937_64 random(8);
  std::exponential_distribution<double> wait(1.0 / 3e-3);
  double last = 0.0;
  std::vector<double> times;
  for (int k = 0; k < 20000; ++k) times.push_back(last += k % 3 == 0 ? 1e-4 + wait(random) : 1e-6);
  const Recording r = read_log(timed_rows(20000, [&](int k) { return times[std::size_t(k)]; }));
  EXPECT_THAT(r.cautions, IsEmpty());
}

TEST(ArrivalStamps, are_not_seen_in_jitter) {
  // Every interval differs: from a third to twice the usual.
  const auto time = [](int k) {
    return 0.01 * k + 0.003 * std::sin(1.7 * k) + 0.001 * std::cos(0.31 * k);
  };
  const Recording r = read_log(timed_rows(500, time));
  EXPECT_THAT(r.cautions, IsEmpty());
  EXPECT_NEAR(r.gyr.t[321], time(321), 1e-9);
}

// Accelerometer and gyroscope in rows of their own, at one and two times 100 Hz; the current, a
// temperature and a position in all of them.
TEST(RowsOfOneTime, that_share_a_column_which_agrees_are_one_reading) {
  std::string content =
      "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z,current,temp,pos_x,pos_y,pos_z\n";
  for (int k = 0; k < 400; ++k) {
    const std::string t = fmt::format("{:.3f}", 0.005 * k);
    const std::string shared =
        fmt::format("{:.4f},{:.2f},{},0,1", 0.5 + 0.001 * (k % 7), 20.0 + 0.01 * k, 0.001 * k);
    if (k % 2 == 0) content += fmt::format("{},{},2,3,,,,,,,{}\n", t, k, shared);
    content += fmt::format("{},,,,{},5,6,,,,{}\n", t, k, shared);
    if (k % 10 == 0) content += fmt::format("{},,,,,,,{},8,9,{}\n", t, k, shared);
  }
  const Recording r = read_log(content);
  EXPECT_EQ(r.acc.size(), 200U);
  EXPECT_EQ(r.gyr.size(), 400U);
  EXPECT_EQ(r.mag[0].size(), 40U);
  EXPECT_EQ(r.aux.at("current").v.size(), 400U);
  ASSERT_TRUE(r.pos.has_value());
  EXPECT_EQ(r.pos->size(), 400U);
  EXPECT_THAT(r.cautions, IsEmpty());
}

TEST(RowsOfOneTime, with_another_current_keep_the_first_and_the_notes_say_so) {
  std::string content = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z,current\n";
  for (int k = 0; k < 100; ++k) {
    const std::string t = fmt::format("{:.2f}", 0.01 * k);
    content += fmt::format("{},{},2,3,,,,7,8,9,0.5\n{},,,,{},5,6,,,,0.6\n", t, k, t, k);
  }
  const Recording r = read_log(content);
  EXPECT_EQ(r.gyr.size(), 100U);
  EXPECT_EQ(r.aux.at("current").v.front(), 0.5);
  EXPECT_THAT(r.notes, Contains(HasSubstr("another temperature or current: 100")));
}

TEST(RowsOfOneTime, with_other_readings_of_a_sensor_are_refused_for_all_a_shared_column) {
  std::string content = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z,current\n";
  for (int k = 0; k < 200; ++k) {
    content += fmt::format("{:.2f},{},2,3,4,5,6,7,8,9,0.5\n", 0.01 * std::floor(0.003 * k * k), k);
  }
  EXPECT_THAT(refusal(content).problem, HasSubstr("the time of another row and other readings"));
}

// k / rate, rounded to the step; the greatest distance of the times read from the true ones, their
// mean taken out.
struct RoundedLog {
  Recording recording;
  double worst_s = 0.0;
};
RoundedLog rounded_log(double rate_hz, double step_s, int count) {
  RoundedLog out;
  const auto time = [=](int k) { return step_s * std::round(k / rate_hz / step_s); };
  out.recording = read_log(timed_rows(count, time));
  const VectorSeries& gyr = out.recording.gyr;
  double mean = 0.0;
  for (std::size_t i = 0; i < gyr.size(); ++i) {
    mean += (gyr.t[i] - gyr.v[i][0] / rate_hz) / double(gyr.size());
  }
  for (std::size_t i = 0; i < gyr.size(); ++i) {
    out.worst_s = std::max(out.worst_s, std::abs(gyr.t[i] - gyr.v[i][0] / rate_hz - mean));
  }
  return out;
}

TEST(RoundedTimes, of_a_steady_clock_become_even_again) {
  for (const auto& [rate_hz, step_s] :
       {std::pair(104.0, 0.01), {104.0, 0.005}, {80.0, 0.01}, {52.0, 0.01}, {119.0, 0.01}}) {
    SCOPED_TRACE(fmt::format("{} Hz, {} s", rate_hz, step_s));
    const RoundedLog log = rounded_log(rate_hz, step_s, 3000);
    EXPECT_EQ(log.recording.gyr.size(), 3000U) << "of two rows of one time both are samples";
    EXPECT_LT(log.worst_s, 0.05 * step_s);
    ASSERT_THAT(log.recording.cautions, ElementsAre(HasSubstr("given in steps of")));
    EXPECT_THAT(log.recording.cautions[0], HasSubstr("log more digits"));
  }
}

TEST(RoundedTimes, that_are_even_or_fine_stay_as_they_are) {
  for (const auto& [rate_hz, step_s] :
       {std::pair(100.0, 0.01), {50.0, 0.01}, {104.0, 0.001}, {104.0, 1e-6}}) {
    SCOPED_TRACE(fmt::format("{} Hz, {} s", rate_hz, step_s));
    EXPECT_THAT(rounded_log(rate_hz, step_s, 3000).recording.cautions, IsEmpty());
  }
}

TEST(RoundedTimes, are_not_what_lost_samples_leave) {
  // One of fifty of 100 Hz, or of seven, at irregular places.
  for (const unsigned lost : {50U, 7U}) {
    std::string content = kTimedHeader;
    unsigned random = 1;
    for (int k = 0; k < 3000; ++k) {
      random = random * 1664525U + 1013904223U;
      if ((random >> 16) % lost == 0) continue;
      content += timed_row(fmt::format("{:.2f}", 0.01 * k), k);
    }
    const Recording r = read_log(content);
    EXPECT_THAT(r.cautions, IsEmpty()) << lost;
    for (std::size_t i = 0; i < r.gyr.size(); ++i)
      ASSERT_NEAR(r.gyr.t[i], 0.01 * r.gyr.v[i][0], 1e-9);
  }
}

TEST(RoundedTimes, keep_pauses_and_the_phase_of_each_stretch) {
  std::string content = kTimedHeader;
  const auto time = [](int k) { return k / 104.0 + (k >= 1500 ? 3.0 : 0.0); };
  for (int k = 0; k < 3000; ++k) content += timed_row(fmt::format("{:.2f}", time(k)), k);
  const Recording r = read_log(content);
  ASSERT_EQ(r.gyr.size(), 3000U);
  for (int k = 0; k < 3000; ++k) ASSERT_NEAR(r.gyr.t[std::size_t(k)], time(k), 0.001) << k;
}

TEST(RoundedTimes, of_samples_that_come_unevenly_are_told_of_and_left) {
  std::string content = kTimedHeader;
  unsigned random = 1;
  double t = 0.0;
  for (int k = 0; k < 2000; ++k) {
    content += timed_row(fmt::format("{:.3f}", 0.01 * std::round(t / 0.01)), k);
    random = random * 1664525U + 1013904223U;
    t += 0.0145 + 0.012 * (double(random >> 8) / double(1U << 24) - 0.5);
  }
  const Recording r = read_log(content);
  EXPECT_THAT(r.cautions, Contains(HasSubstr("do not come evenly")));
}

// 500 Hz in steps of 2 ms cut off with the rounding of binary numbers; 1 kHz with some jitter in
// ms.
TEST(RoundedTimes, of_a_clock_that_is_steady_to_a_step_become_even_again) {
  unsigned random = 1;
  const auto uniform = [&random] {
    random = random * 1664525U + 1013904223U;
    return double(random >> 8) / double(1U << 24) - 0.5;
  };
  struct Case {
    double h;
    const char* format;
    std::function<double(int)> stamp;
  };
  const Case cases[] = {
      {0.002, "{:.3f}", [](int k) { return 0.002 * std::floor(0.002 * k / 0.002); }},
      {0.001, "{:.3f}", [&](int k) { return 0.001 * std::round(k + 0.6 * uniform() + 0.5); }},
      {1 / 104.0, "{:.2f}", [&](int k) { return k / 104.0 + 0.004 * uniform(); }}};
  for (const Case& c : cases) {
    std::string content = kTimedHeader;
    for (int k = 0; k < 4000; ++k) {
      content += timed_row(fmt::format(fmt::runtime(c.format), c.stamp(k)), k);
    }
    const Recording r = read_log(content);
    ASSERT_EQ(r.gyr.size(), 4000U) << "of two rows of one time both are samples";
    ASSERT_THAT(r.cautions, ElementsAre(HasSubstr("each within a step")));
    for (std::size_t k = 0; k < 4000; ++k) {
      ASSERT_NEAR(r.gyr.t[k] - r.gyr.t[0], c.h * double(k), 0.3 * c.h);
    }
  }
}

}  // namespace
}  // namespace magimu
