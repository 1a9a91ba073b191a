// SPDX-License-Identifier: BSD-3-Clause
// The times of a stream, by what their first rows show: as those of a file.
#include "recording/live/stream_times.h"
#include "recording/csv/csv.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>

#include "recording/live/sample_lines.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// Lines with these texts in the time column.
std::string lines_with(const std::function<std::string(int)>& time, int rows = 100,
                       const std::string& column = "t") {
  std::string out = column + ",acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
  for (int k = 0; k < rows; ++k) out += time(k) + ",1,2,3,4,5,6,7,8,9\n";
  return out;
}

struct Read {
  std::vector<StreamSample> samples;
  std::vector<std::string> said;
  std::optional<RefusedTimes> refused;
};

Read read(const std::string& text, const CsvOptions& csv = {}) {
  SampleLines lines("test", {.csv = csv, .columns = "", .recognise_times = true});
  lines.push(text);
  lines.finish();
  return {lines.take(), lines.take_complaints(), lines.refused_times()};
}

double interval(const Read& r) {
  return (r.samples.back().t - r.samples.front().t) / double(r.samples.size() - 1);
}

TEST(StreamTimes, a_clock_of_whole_seconds_asks_for_the_rate_and_the_rate_wins) {
  std::string text = lines_with([](int) { return ""; }, 0);
  for (int k = 0; k < 2500; ++k) text += fmt::format("{},{},2,3,4,5,6,7,8,9\n", 5 + k / 100, k);
  const Read without = read(text);
  ASSERT_TRUE(without.refused.has_value());
  EXPECT_THAT(without.refused->remedy, HasSubstr("--rate HZ"));
  CsvOptions csv;
  csv.rate_hz = 100.0;
  const Read with = read(text, csv);
  EXPECT_THAT(with.samples, SizeIs(2500));
  EXPECT_NEAR(interval(with), 0.01, 1e-9);
  // Of a whole file the bursts tell.
  EXPECT_NEAR(csv_recording(text, "rec").acc.rate_hz(), 100.0, 0.5);
  EXPECT_NEAR(csv_recording(text, "rec", csv).acc.rate_hz(), 100.0, 1e-9);
}

TEST(StreamTimes, are_recognised_in_ms_us_and_ns_since_boot_or_1970) {
  const std::pair<const char*, std::function<std::string(int)>> cases[] = {
      {"ms", [](int k) { return fmt::format("{}", 5000.0 + 12.5 * k); }},
      {"us", [](int k) { return fmt::format("{}", 12500 * k); }},
      {"ns", [](int k) { return fmt::format("{}", 12500000LL * k); }},
      {"ms", [](int k) { return fmt::format("{}", 1780000000000LL + 10 * k); }},
      {"us", [](int k) { return fmt::format("{}", 1780000000000000LL + 10000LL * k); }},
      {"ns", [](int k) { return fmt::format("{}", 1780000000000000000LL + 10000000LL * k); }},
  };
  for (const auto& [unit, time] : cases) {
    const Read r = read(lines_with(time));
    ASSERT_THAT(r.samples, SizeIs(100)) << unit;
    EXPECT_NEAR(interval(r), 0.01125, 0.00126) << unit;
    EXPECT_THAT(r.said, Contains(testing::AllOf(HasSubstr(fmt::format("is read as {}", unit)),
                                                HasSubstr(fmt::format("--unit t={}", unit)))));
  }
}

TEST(StreamTimes, say_nothing_of_seconds_and_of_units_that_are_known) {
  const auto seconds = [](int k) { return fmt::format("{}", 0.0125 * k); };
  EXPECT_THAT(read(lines_with(seconds)).said, IsEmpty());
  const auto ms = [](int k) { return fmt::format("{}", 12.5 * k); };
  CsvOptions given;
  given.time_unit = 1e-3;
  const Read by_option = read(lines_with(ms), given);
  EXPECT_THAT(by_option.said, IsEmpty());
  EXPECT_NEAR(interval(by_option), 0.0125, 1e-9);
  const Read by_header = read(lines_with(ms, 100, "t (ms)"));
  EXPECT_THAT(by_header.said, IsEmpty());
  EXPECT_NEAR(interval(by_header), 0.0125, 1e-9);
}

TEST(StreamTimes, that_are_ambiguous_or_count_samples_are_refused_with_the_option_that_helps) {
  const Read counter = read(lines_with([](int k) { return fmt::format("{}", k); }));
  EXPECT_THAT(counter.samples, IsEmpty());
  ASSERT_TRUE(counter.refused);
  EXPECT_THAT(counter.refused->remedy, HasSubstr("--rate HZ"));
  const Read either = read(lines_with([](int k) { return fmt::format("{}", 900 * k); }));
  EXPECT_THAT(either.samples, IsEmpty());
  ASSERT_TRUE(either.refused);
  EXPECT_THAT(either.refused->remedy, HasSubstr("--unit t=ms or --unit t=us"));
}

TEST(StreamTimes, follow_the_rate_that_is_given) {
  CsvOptions csv;
  csv.rate_hz = 50.0;
  // A counter that has lost 40 samples; a column that is no counter.
  const Read counter =
      read(lines_with([](int k) { return fmt::format("{}", k < 50 ? k : k + 40); }), csv);
  ASSERT_THAT(counter.samples, SizeIs(100));
  EXPECT_NEAR(counter.samples[49].t, 0.98, 1e-12);
  EXPECT_NEAR(counter.samples[50].t, 1.8, 1e-12);
  EXPECT_THAT(counter.said, Contains(HasSubstr("counted by column")));
  const Read rows = read(lines_with([](int k) { return fmt::format("{}", 0.1 * (k / 4)); }), csv);
  ASSERT_THAT(rows.samples, SizeIs(100));
  EXPECT_NEAR(rows.samples[99].t, 99.0 / 50.0, 1e-12);
}

// Four at a time, the last of them on time, with a clock that is 0.3 % fast later on; and a gap.
TEST(StreamTimes, of_bursts_are_made_even) {
  const auto measured = [](int k) {
    return (k < 400 ? 0.01 : 0.00997) * k + (k < 1200 ? 0.03 : 3.0);
  };
  const Read r = read(lines_with(
      [&](int k) { return fmt::format("{:.6f}", measured(k / 4 * 4 + 3) + 1e-4 * (k % 4)); },
      1600));
  ASSERT_THAT(r.samples, SizeIs(1600));
  EXPECT_THAT(r.said,
              Contains(testing::AllOf(HasSubstr("stamped on arrival"), HasSubstr("--rate 100"))));
  double worst = 0.0, shortest = 1.0;
  for (int k = 1; k < 1600; ++k) {
    const double dt = r.samples[std::size_t(k)].t - r.samples[std::size_t(k - 1)].t;
    if (k != 1200 && k != 400) worst = std::max(worst, std::abs(dt - 0.01));
    shortest = std::min(shortest, dt);
  }
  EXPECT_LT(worst, 0.0015);
  EXPECT_GT(shortest, 0.0);
  EXPECT_NEAR(r.samples[1199].t, measured(1199), 0.005);
  EXPECT_NEAR(r.samples[1599].t, measured(1599), 0.03);
}

TEST(StreamTimes, need_no_column_where_there_is_a_rate) {
  std::string text = "acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
  for (int k = 0; k < 30; ++k) text += "1,2,3,4,5,6,7,8,9\n";
  CsvOptions csv;
  csv.rate_hz = 10.0;
  const Read r = read(text, csv);
  ASSERT_THAT(r.samples, SizeIs(30));
  EXPECT_NEAR(r.samples[29].t, 2.9, 1e-12);
}

}  // namespace
}  // namespace magimu
