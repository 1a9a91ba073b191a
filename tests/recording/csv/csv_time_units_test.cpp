// SPDX-License-Identifier: BSD-3-Clause
// A time column whose header or name says another unit than it has: the remedy that is named is the
// one that helps.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "recording/checks/quality.h"
#include "recording/csv/csv.h"
#include "recording/data/units.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

// 50 Hz, times in seconds by `factor`.
std::string fifty_hertz(const std::string& name, double factor, double start = 0.0) {
  std::string out = name + ",ax,ay,az,gx,gy,gz,mx,my,mz\n";
  for (int k = 0; k < 100; ++k) {
    out +=
        fmt::format("{:.10f},{},2,9,0.1,0.2,0.3,20,{},40\n", start + 0.02 * k * factor, k % 5, k);
  }
  return out;
}

CsvOptions times_in(const std::string& unit) {
  CsvOptions options;
  options.time_unit = unit_in_ours("t", unit);
  return options;
}

// What stands behind "--unit t=".
std::string unit_of_remedy(const std::string& remedy) {
  const std::size_t at = remedy.find("--unit t=");
  if (at == std::string::npos) return "";
  const std::string rest = remedy.substr(at + 9);
  return rest.substr(0, rest.find_first_of(" ,;"));
}

TEST(CsvTimeUnits, a_header_that_contradicts_its_column_is_refused_with_the_unit_that_helps) {
  for (const auto& [name, factor] : {std::pair("time_ms", 1.0),
                                     {"time (us)", 1.0},
                                     {"time_ms", 1e6},
                                     {"time (s)", 1e3},
                                     {"time_us", 1e9}}) {
    SCOPED_TRACE(name);
    const std::string text = fifty_hertz(name, factor);
    const InputError error = test::error_of([&] { csv_recording(text, "log.csv"); });
    EXPECT_THAT(error.problem, HasSubstr("it seems to be in"));
    const Recording r = csv_recording(text, "log.csv", times_in(unit_of_remedy(error.remedy)));
    EXPECT_NEAR(r.acc.t.back(), 0.02 * 99, 1e-6);
  }
}

TEST(CsvTimeUnits, a_name_that_two_makers_use_is_read_as_the_column_says) {
  const Recording micro = csv_recording(fifty_hertz("SampleTimeFine", 1e6), "dot.csv");
  EXPECT_NEAR(micro.acc.t.back(), 0.02 * 99, 1e-6);
  EXPECT_THAT(micro.notes, Contains(HasSubstr("it is read as us")));
  const Recording tenths = csv_recording(fifty_hertz("SampleTimeFine", 1e4), "mti.csv");
  EXPECT_NEAR(tenths.acc.t.back(), 0.02 * 99, 1e-6);
}

TEST(CsvTimeUnits, days_of_a_spreadsheet_are_named) {
  const std::string text = fifty_hertz("Timestamp", 1.0 / 86400.0, 45746.0);
  const InputError error = test::error_of([&] { csv_recording(text, "log.csv"); });
  EXPECT_THAT(error.remedy, HasSubstr("--unit t=86400 for days"));
  EXPECT_NEAR(csv_recording(text, "log.csv", times_in("86400")).acc.t.back(), 0.02 * 99, 1e-4);
}

TEST(CsvTimeUnits, what_the_checks_suggest_is_no_unit_that_was_given) {
  // In us, and given as ms: a sample every 20 s.
  const std::string text = fifty_hertz("time", 1e6);
  const Recording r = csv_recording(text, "log.csv", times_in("ms"));
  std::string remedy;
  for (const Issue& issue : check_recording(r)) {
    if (issue.kind == "time_unit") remedy = issue.remedy;
  }
  ASSERT_EQ(unit_of_remedy(remedy), "us");
  EXPECT_THAT(remedy, HasSubstr("multiply the times by 0.001"));
  EXPECT_NEAR(csv_recording(text, "log.csv", times_in("us")).acc.t.back(), 0.02 * 99, 1e-6);
}

// The same 50 Hz, with the time in two columns: whole seconds, and what `rest` makes of the others.
template <class Rest>
std::string in_two_columns(const std::string& names, const Rest& rest) {
  std::string out = names + ",ax,ay,az,gx,gy,gz,mx,my,mz\n";
  for (int k = 0; k < 150; ++k) {
    out += fmt::format("{},{},{},2,9,0.1,0.2,0.3,20,{},40\n", k / 50, rest(k), k % 5, k);
  }
  return out;
}

TEST(CsvTimeUnits, seconds_and_what_is_beyond_them_are_one_time) {
  for (const auto& [names, factor] : {std::pair("Seconds,Milliseconds", 20),
                                      {"tv_sec,tv_usec", 20'000},
                                      {"stamp.sec,stamp.nanosec", 20'000'000}}) {
    SCOPED_TRACE(names);
    const Recording r = csv_recording(
        in_two_columns(names, [by = factor](int k) { return (k % 50) * by; }), "log.csv");
    EXPECT_NEAR(r.acc.t.back(), 0.02 * 149, 1e-6);
    EXPECT_THAT(r.cautions, testing::IsEmpty());
  }
  // All of the time once more.
  const Recording r = csv_recording(
      in_two_columns("seconds,milliseconds", [](int k) { return 20 * k; }), "log.csv");
  EXPECT_NEAR(r.acc.t.back(), 0.02 * 149, 1e-6);
}

TEST(CsvTimeUnits, lines_that_end_with_a_carriage_return_alone) {
  std::string text = fifty_hertz("t", 1.0);
  std::ranges::replace(text, '\n', '\r');
  EXPECT_EQ(csv_recording(text, "log.csv").acc.size(), 100u);
  std::string longer = "t,ax,ay,az,gx,gy,gz,mx,my,mz\r";
  for (int k = 0; k < 5000; ++k) longer += fmt::format("{:.2f},1,2,9,0,0,0,1,2,{}\r", 0.02 * k, k);
  EXPECT_EQ(csv_recording(longer, "log.csv").acc.size(), 5000u);
}

}  // namespace
}  // namespace magimu
