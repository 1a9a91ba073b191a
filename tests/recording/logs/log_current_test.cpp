// SPDX-License-Identifier: BSD-3-Clause
// The battery's current, whose field a compass reads, too.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "recording/read.h"
#include "tests/recording/log_writers.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

constexpr int kCurrentCount = 50;

double log_amperes(int k) { return 10.0 + 0.25 * (k % 7); }

Recording read_log_with_current(const std::string& content) {
  const test::TempFolder folder;
  return read_recording(folder.write("log", content));
}

void expect_current(const Recording& r) {
  ASSERT_TRUE(r.aux.contains("current"));
  const ScalarSeries& current = r.aux.at("current");
  ASSERT_EQ(current.v.size(), std::size_t(kCurrentCount));
  for (int k = 0; k < kCurrentCount; ++k) {
    EXPECT_NEAR(current.v[std::size_t(k)], log_amperes(k), 1e-6);
    EXPECT_NEAR(current.t[std::size_t(k)] - r.gyr.t[0], 0.1 * k, 1e-9);
  }
}

TEST(LogCurrent, of_ardupilot_is_in_amperes) {
  std::string log = test::dataflash(600) +
                    test::dataflash_format(140, 3 + 8 + 1 + 8, "BAT", "QBff", "TimeUS,I,Volt,Curr");
  for (int k = 0; k < kCurrentCount; ++k) {
    log += test::Bytes()
               .add("\xA3\x95\x8C")
               .put(std::uint64_t(1'000'000 + 100'000 * k))
               .put('\0')
               .put(12.0F)
               .put(float(log_amperes(k)))
               .text;
  }
  expect_current(read_log_with_current(log));
}

TEST(LogCurrent, of_old_ardupilot_is_in_hundredths) {
  std::string log = test::dataflash(600) +
                    test::dataflash_format(140, 3 + 4 + 4, "CURR", "Ihh", "TimeMS,Volt,Curr");
  for (int k = 0; k < kCurrentCount; ++k) {
    log += test::Bytes()
               .add("\xA3\x95\x8C")
               .put(std::uint32_t(1'000 + 100 * k))
               .put(std::int16_t(1200))
               .put(std::int16_t(std::lround(100.0 * log_amperes(k))))
               .text;
  }
  expect_current(read_log_with_current(log));
}

TEST(LogCurrent, of_px4_is_in_amperes_and_minus_one_is_none) {
  std::string log = test::ulog(600);
  log += test::ulog_message('F',
                            "battery_status:uint64_t timestamp;float voltage_v;"
                            "float current_a;");
  log += test::ulog_message(
      'A', test::Bytes().put('\0').put(std::uint16_t(9)).add("battery_status").text);
  const auto message = [](std::int64_t t_us, float current_a) {
    return test::ulog_message('D', test::Bytes()
                                       .put(std::uint16_t(9))
                                       .put(std::uint64_t(t_us))
                                       .put(12.0F)
                                       .put(current_a)
                                       .text);
  };
  for (int k = 0; k < kCurrentCount; ++k)
    log += message(1'000'000 + 100'000 * k, float(log_amperes(k)));
  log += message(1'000'000 + 100'000 * kCurrentCount, -1.0F);
  expect_current(read_log_with_current(log));
}

TEST(LogCurrent, is_not_needed) {
  EXPECT_FALSE(read_log_with_current(test::dataflash(100)).aux.contains("current"));
}

}  // namespace
}  // namespace magimu
