// SPDX-License-Identifier: BSD-3-Clause
// Lines of one sensor or one number each: Teleplot, Android's GnssLogger, tables that have one
// sensor after the other; options that mean nothing for a kind of file are refused.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <string>

#include "recording/read.h"
#include "tests/recording/log_writers.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::HasSubstr;

constexpr int kSensorRows = 2000;
constexpr std::array<const char*, 3> kRowSensors = {"acc", "gyr", "mag"};

double row_reading(int sensor, int k, int axis) {
  return (sensor == 0 && axis == 2 ? 9.8 : 10.0 * sensor) + 0.01 * (k % 100) + 0.25 * axis;
}

Recording read_rows(const std::string& content, const CsvOptions& options = {}) {
  const test::TempFolder folder;
  return read_recording(folder.write("log.txt", content), options);
}

void expect_sensor_rows(const Recording& r) {
  ASSERT_EQ(r.mag.size(), 1u);
  for (int s = 0; s < 3; ++s) {
    const VectorSeries& series = s == 0 ? r.acc : s == 1 ? r.gyr : r.mag[0];
    ASSERT_EQ(series.size(), std::size_t(kSensorRows)) << kRowSensors[std::size_t(s)];
    for (int k = 0; k < kSensorRows; ++k) {
      EXPECT_NEAR(series.t[std::size_t(k)] - series.t[0], 0.02 * k, 1e-6);
      for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(series.v[std::size_t(k)][a], row_reading(s, k, a), 1e-9);
      }
    }
  }
}

std::string teleplot_text(bool times) {
  std::string out = "booting\n";
  for (int k = 0; k < kSensorRows; ++k) {
    for (int s = 0; s < 3; ++s) {
      for (int a = 0; a < 3; ++a) {
        const std::string time = times ? fmt::format("{}:", 1627551892437 + 20 * k) : "";
        out += fmt::format(">{}_{}:{}{:.4f}{}\n", kRowSensors[std::size_t(s)], "xyz"[a], time,
                           row_reading(s, k, a), s == 2 ? "\xC2\xA7uT|g" : "");
      }
    }
    if (k % 100 == 0) out += ">log:a text|t\n>free_heap:123\n";
  }
  return out;
}

TEST(SensorRows, of_teleplot_with_times_in_ms) {
  expect_sensor_rows(read_rows(teleplot_text(true)));
}

TEST(SensorRows, of_teleplot_without_times_need_a_rate) {
  EXPECT_THAT(test::error_of([] { read_rows(teleplot_text(false)); }).remedy, HasSubstr("--rate"));
  CsvOptions options;
  options.rate_hz = 50.0;
  expect_sensor_rows(read_rows(teleplot_text(false), options));
}

TEST(SensorRows, of_teleplot_of_which_a_line_is_lost_lose_that_reading_alone) {
  std::string text = teleplot_text(true);
  const std::size_t line = text.find(">gyr_y", text.size() / 2);
  text.erase(line, text.find('\n', line) + 1 - line);
  const Recording r = read_rows(text);
  EXPECT_EQ(r.gyr.size(), std::size_t(kSensorRows - 1));
  EXPECT_EQ(r.acc.size(), std::size_t(kSensorRows));
}

// The header of each kind of row stands behind '#'; the last three numbers are the phone's biases.
TEST(SensorRows, of_gnss_logger) {
  std::string text =
      "# \n# Header Description:\n# \n"
      "# Version: v3.0.0.1 Platform: 11 Manufacturer: Google Model: Pixel 4\n# \n"
      "# Raw,utcTimeMillis,TimeNanos,LeapSecond\n# \n"
      "# UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,UncalAccelYMps2,"
      "UncalAccelZMps2,BiasXMps2,BiasYMps2,BiasZMps2\n# \n"
      "# UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,"
      "UncalGyroZRadPerSec,DriftXRadPerSec,DriftYRadPerSec,DriftZRadPerSec\n# \n"
      "# UncalMag,utcTimeMillis,elapsedRealtimeNanos,UncalMagXMicroT,UncalMagYMicroT,"
      "UncalMagZMicroT,BiasXMicroT,BiasYMicroT,BiasZMicroT\n# \n";
  const std::array<const char*, 3> words = {"UncalAccel", "UncalGyro", "UncalMag"};
  for (int k = 0; k < kSensorRows; ++k) {
    for (int s = 0; s < 3; ++s) {
      // The clock of the day is set in between.
      text += fmt::format("{},{},{},{:.4f},{:.4f},{:.4f},0.5,0.5,0.5\n", words[std::size_t(s)],
                          1627551892437 + 20 * k - (k > 700 ? 5000 : 0),
                          1266000000000 + 20'000'000LL * k, row_reading(s, k, 0),
                          row_reading(s, k, 1), row_reading(s, k, 2));
    }
    if (k % 50 == 0) text += "Fix,GPS,37.42,-122.08,10.0\nRaw,1627551892437,23423423,18\n";
  }
  expect_sensor_rows(read_rows(text));
}

TEST(SensorRows, of_one_sensor_after_the_other) {
  std::string text = "time,sensor,x,y,z\n";
  for (int s = 0; s < 3; ++s) {
    for (int k = 0; k < kSensorRows; ++k) {
      text += fmt::format("{:.2f},{},{:.4f},{:.4f},{:.4f}\n", 0.02 * k, kRowSensors[std::size_t(s)],
                          row_reading(s, k, 0), row_reading(s, k, 1), row_reading(s, k, 2));
    }
  }
  ASSERT_GT(text.size(), std::size_t(1 << 17));  // the head does not show all sensors
  expect_sensor_rows(read_rows(text));
}

TEST(SensorRows, options_of_other_kinds_of_files_are_refused) {
  CsvOptions sensor;
  sensor.sensors = {"mag=foo"};
  EXPECT_THAT(test::error_of([&] { read_rows("t,acc_x\n0,1\n", sensor); }).problem,
              HasSubstr("--sensor mag=foo"));
  CsvOptions unit;
  unit.time_unit = 1e-3;
  EXPECT_THAT(test::error_of([&] { read_rows(test::dataflash(60), unit); }).remedy,
              HasSubstr("--unit t="));
}

}  // namespace
}  // namespace magimu
