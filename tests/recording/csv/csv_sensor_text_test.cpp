// SPDX-License-Identifier: BSD-3-Clause
// What sensors and their libraries' examples write by themselves: units in brackets behind labels,
// lines with a checksum, tables with columns that stay empty.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <string>

#include "recording/csv/csv.h"
#include "recording/csv/dialects/line_translator.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr int kLines = 200;
constexpr double kMilliG = 9.80665e-3, kDps = M_PI / 180.0;

double wave(int k, int axis) { return std::round(100.0 * std::sin(0.1 * k + axis)); }

CsvOptions at_100_hz() {
  CsvOptions options;
  options.rate_hz = 100.0;
  return options;
}

// Each axis reads wave(k, axis) times the unit.
void expect_waves(const Recording& r, double acc, double gyr, double mag, int lines = kLines) {
  ASSERT_EQ(r.mag.size(), 1u);
  ASSERT_EQ(r.acc.size(), std::size_t(lines));
  for (int k = 0; k < lines; ++k) {
    for (int a = 0; a < 3; ++a) {
      ASSERT_NEAR(r.acc.v[std::size_t(k)][a], acc * wave(k, a), 1e-9) << k;
      ASSERT_NEAR(r.gyr.v[std::size_t(k)][a], gyr * wave(k, a), 1e-9) << k;
      ASSERT_NEAR(r.mag[0].v[std::size_t(k)][a], mag * wave(k, a), 1e-9) << k;
    }
  }
}

// One line for each k, {0}, {1}, {2} are the readings of the axes.
std::string lines_of(const std::string& format, int lines = kLines) {
  std::string text;
  for (int k = 0; k < lines; ++k) {
    text += fmt::format(fmt::runtime(format), wave(k, 0), wave(k, 1), wave(k, 2)) + "\n";
  }
  return text;
}

TEST(CsvSensorText, of_an_icm_20948_has_units_in_brackets_behind_the_labels) {
  const Recording r = csv_recording(
      "Initialization of the sensor returned: All is well.\n" +
          lines_of("Scaled. Acc (mg) [ {0:09.2f}, {1:09.2f}, {2:09.2f} ], Gyr (DPS) [ {0:09.2f}, "
                   "{1:09.2f}, {2:09.2f} ], Mag (uT) [ {0:09.2f}, {1:09.2f}, {2:09.2f} ], Tmp (C) "
                   "[ 00031.00 ]"),
      "log.txt", at_100_hz());
  expect_waves(r, kMilliG, kDps, 1.0);
  const Recording raw = csv_recording(
      lines_of("RAW. Acc [ {0:06.0f}, {1:06.0f}, {2:06.0f} ], Gyr [ {0:06.0f}, {1:06.0f}, "
               "{2:06.0f} ], Mag [ {0:06.0f}, {1:06.0f}, {2:06.0f} ], Tmp [ 03338 ]"),
      "log.txt", at_100_hz());
  expect_waves(raw, 1.0, 1.0, 1.0);
}

TEST(CsvSensorText, has_units_in_square_brackets_or_behind_the_numbers) {
  expect_waves(csv_recording(lines_of("Acc [mg]: {0}, {1}, {2}; Gyr [deg/s]: {0}, {1}, {2}; "
                                      "Mag [mG]: {0}, {1}, {2}"),
                             "log.txt", at_100_hz()),
               kMilliG, kDps, 0.1);
  expect_waves(csv_recording(lines_of("Accel: {0}, {1}, {2} (mg) Gyro: {0}, {1}, {2} (rad/s) "
                                      "Mag: {0}, {1}, {2} (uT)"),
                             "log.txt", at_100_hz()),
               kMilliG, 1.0, 1.0);
  expect_waves(
      csv_recording(lines_of("X-acceleration: {0} mg Y-acceleration: {1} mg Z-acceleration: {2} mg "
                             "X-gyro rate: {0} degrees/sec Y-gyro rate: {1} degrees/sec Z-gyro "
                             "rate: {2} degrees/sec X-mag field: {0} mG Y-mag field: {1} mG Z-mag "
                             "field: {2} mG"),
                    "log.txt", at_100_hz()),
      kMilliG, kDps, 0.1);
}

TEST(CsvSensorText, has_units_glued_to_the_numbers) {
  expect_waves(csv_recording(lines_of("AX:{0}g AY:{1}g AZ:{2}g GX:{0}dps GY:{1}dps GZ:{2}dps "
                                      "MX:{0}uT MY:{1}uT MZ:{2}uT"),
                             "log.txt", at_100_hz()),
               1e3 * kMilliG, kDps, 1.0);
}

TEST(CsvSensorText, labels_keep_what_is_no_unit) {
  const std::vector<LabelledNumber> numbers = labelled_numbers("Acc. x (left): 1 y: 2 [m/s^2]");
  ASSERT_EQ(numbers.size(), 2u);
  EXPECT_EQ(numbers[0].unit, "");
  EXPECT_EQ(numbers[1].unit, "m/s^2");
}

std::string with_checksum(const std::string& text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  return fmt::format("${}*{:02X}\n", text, sum);
}

// {0}, {1}, {2} as above.
std::string checked(const std::string& format, int k) {
  return with_checksum(fmt::format(fmt::runtime(format), wave(k, 0), wave(k, 1), wave(k, 2)));
}

TEST(CsvSensorText, of_vectornav_is_read_by_its_published_layout) {
  const std::string sensors =
      "{0:+08.3f},{1:+08.3f},{2:+08.3f},{0:+08.3f},{1:+08.3f},{2:+08.3f},"
      "{0:+08.3f},{1:+08.3f},{2:+08.3f}";
  for (const std::string& format :
       {"VNYMR,+000.100,-000.200,+000.300," + sensors, "VNMAR," + sensors,
        "VNIMU," + sensors + ",+31.0,+101.300", "VNQMR,+0.1,+0.2,+0.3,+0.9," + sensors}) {
    std::string text = "7,-00.12*5C\n";  // its first line is cut off
    for (int k = 0; k < kLines; ++k) {
      text += checked(format, k);
      if (k % 10 == 0) text += with_checksum("GPGGA,120000.00,4717.1,N,00833.9,E,1,08,1.0,499.6,M");
    }
    const Recording r = csv_recording(text, "log.txt", at_100_hz());
    expect_waves(r, 1.0, 1.0, 100.0);
    EXPECT_THAT(r.notes, Contains(HasSubstr("other lines are ignored: $GPGGA")));
  }
  EXPECT_THAT(test::error_of([&] {
                std::string text;
                for (int k = 0; k < kLines; ++k) text += checked("VNMAR," + sensors, k);
                csv_recording(text, "log.txt");
              }).remedy,
              HasSubstr("--rate HZ"));
}

TEST(CsvSensorText, with_checksums_of_unknown_words_is_read_by_the_columns_that_are_told) {
  std::string text;
  for (int k = 0; k < kLines; ++k) {
    text += checked("PIMU,7,{0},{1},{2},{0},{1},{2},{0},{1},{2}", k);
  }
  CsvOptions options = at_100_hz();
  options.header = "-,-,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z";
  expect_waves(csv_recording(text, "log.txt", options), 1.0, 1.0, 1.0);
}

TEST(CsvSensorText, a_line_with_a_wrong_checksum_is_broken) {
  std::string text;
  for (int k = 0; k < kLines; ++k) {
    std::string line = checked("VNMAR,{0},{1},{2},{0},{1},{2},{0},{1},{2}", k);
    if (k == kLines - 1) line.replace(line.find(','), 2, ",9");
    text += line;
  }
  const Recording r = csv_recording(text, "log.txt", at_100_hz());
  expect_waves(r, 1.0, 1.0, 100.0, kLines - 1);
  EXPECT_THAT(r.cautions, Contains(HasSubstr("cannot be read: 1 of")));
}

TEST(CsvSensorText, of_mt_manager_has_comments_and_columns_that_stay_empty) {
  std::string text = "// Start Time: Unknown\n// Update Rate: 100.0Hz\n// Option Flags: none \n";
  text += "PacketCounter\tSampleTimeFine\tUTC_Nano\tUTC_Year\tUTC_Month\tUTC_Valid";
  for (const char* sensor : {"Acc", "Gyr", "Mag"}) {
    for (const char axis : {'X', 'Y', 'Z'}) text += fmt::format("\t{}_{}", sensor, axis);
  }
  for (const char* end : {"\n", "\t\n"}) {
    std::string whole = text + "\n";
    for (int k = 0; k < kLines; ++k) {
      whole += fmt::format("{:05}\t{}\t\t\t\t", k, 433210 + 100 * k);
      for (int s = 0; s < 3; ++s) {
        for (int a = 0; a < 3; ++a) whole += fmt::format("\t{:.6f}", wave(k, a));
      }
      whole += end;
    }
    const Recording r = csv_recording(whole, "MT_0000_000.txt");
    expect_waves(r, 1.0, 1.0, 1.0);
    EXPECT_NEAR(r.acc.t.back() - r.acc.t.front(), 0.01 * (kLines - 1), 1e-9);
  }
}

// A table with these texts for times, 0.02 s apart.
void expect_times(const std::string& header, const std::function<std::string(int)>& time) {
  std::string text = header + ",acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
  for (int k = 0; k < kLines; ++k) {
    text += fmt::format("{0},{1},{2},{3},{1},{2},{3},{1},{2},{3}\n", time(k), wave(k, 0),
                        wave(k, 1), wave(k, 2));
  }
  const Recording r = csv_recording(text, "log.csv");
  expect_waves(r, 1.0, 1.0, 1.0);
  for (int k = 0; k < kLines; ++k) {
    ASSERT_NEAR(r.acc.t[std::size_t(k)] - r.acc.t[0], 0.02 * k, 1e-6) << time(k);
  }
}

TEST(CsvTimeTexts, of_matlab_pandas_excel_and_fortran_are_seconds) {
  expect_times("Time", [](int k) { return fmt::format("{:g} sec", 0.02 * k); });
  expect_times("time", [](int k) { return fmt::format("{:.10f} min", 0.02 * k / 60.0); });
  expect_times("time", [](int k) { return fmt::format("1 days 00:00:{:09.6f}", 0.02 * k); });
  expect_times("t", [](int k) { return fmt::format("07:{:05.2f}", 0.02 * k); });
  expect_times("t", [](int k) { return fmt::format("{:.2f}D+00", 0.02 * k); });
}

TEST(CsvTimeTexts, may_stand_in_a_first_column_without_a_name) {
  expect_times("", [](int k) { return fmt::format("2023-05-01 12:00:{:06.3f}", 0.02 * k); });
}

}  // namespace
}  // namespace magimu
