// SPDX-License-Identifier: BSD-3-Clause
// One recording in the dialects that programs write: all of them give the same samples.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>

#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/csv/csv.h"
#include "recording/csv/dialects/line_translator.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr int kDialectRows = 30;

// Number c (0: time) of row k.
double number(int k, int c) { return c == 0 ? 0.04 * k : 0.25 * c + 0.5 * k; }

std::string rows(const std::string& separator, const std::function<std::string(int, int)>& field,
                 const std::string& end = "\n") {
  std::string out;
  for (int k = 0; k < kDialectRows; ++k) {
    for (int c = 0; c < 10; ++c) out += (c == 0 ? "" : separator) + field(k, c);
    out += end;
  }
  return out;
}
std::string plain(int k, int c) { return fmt::format("{}", number(k, c)); }
std::string with_comma(int k, int c) {
  std::string text = fmt::format("{:.3f}", number(k, c));
  std::ranges::replace(text, '.', ',');
  return text;
}

const std::string kDialectNames = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z";

std::string names(char separator) {
  std::string out = kDialectNames;
  std::ranges::replace(out, ',', separator);
  return out;
}

Recording read_text(const std::string& content, const CsvOptions& options = {}) {
  const test::TempFolder folder;
  return read_csv(folder.write("log.csv", content), options);
}

void expect_recording(const Recording& r, double tolerance = 1e-12, int count = kDialectRows) {
  ASSERT_EQ(r.acc.size(), std::size_t(count));
  ASSERT_EQ(r.gyr.size(), std::size_t(count));
  ASSERT_EQ(r.mag.at(0).size(), std::size_t(count));
  for (int k = 0; k < count; ++k) {
    const auto i = std::size_t(k);
    EXPECT_NEAR(r.acc.t[i], number(k, 0), 1e-6);
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(r.acc.v[i][a], number(k, 1 + a), tolerance);
      EXPECT_NEAR(r.gyr.v[i][a], number(k, 4 + a), tolerance);
      EXPECT_NEAR(r.mag[0].v[i][a], number(k, 7 + a), tolerance);
    }
  }
}

TEST(CsvDialect, separators_and_decimal_commas) {
  for (const char separator : {';', '\t', '|'}) {
    expect_recording(read_text(names(separator) + "\n" + rows(std::string(1, separator), plain)));
    expect_recording(
        read_text(names(separator) + "\n" + rows(std::string(1, separator), with_comma)));
  }
  expect_recording(read_text(names(' ') + "\n" + rows(" ", plain)));
  expect_recording(read_text("  " + names(' ') + "\n" + rows("   ", plain)));
  expect_recording(read_text(names(' ') + "\n" + rows(" \t", with_comma)));
  expect_recording(read_text(kDialectNames + "\n" +
                             rows(",", [](int k, int c) { return '"' + with_comma(k, c) + '"'; })));
}

TEST(CsvDialect, headers_behind_a_comment_mark_below_a_preamble_and_with_units) {
  const std::string body = rows(",", plain);
  expect_recording(read_text("# " + kDialectNames + "\n" + body));
  expect_recording(read_text("#" + kDialectNames + "\n" + body));
  expect_recording(
      read_text("// Start Time: Unknown\n// Sample rate: 25.0Hz\n" + kDialectNames + "\n" + body));
  expect_recording(read_text("Device: 7\nFirmware, 3.2\n\n" + kDialectNames + "\n" + body));
  expect_recording(
      read_text(kDialectNames + "\ns,m/s^2,m/s^2,m/s^2,rad/s,rad/s,rad/s,uT,uT,uT\n" + body));
  expect_recording(
      read_text("t,Acceleration,,,Gyroscope,,,Magnetic field,,\n,X,Y,Z,X,Y,Z,X,Y,Z\n" + body));
  const Recording r = read_text(kDialectNames + "\ns,mg,mg,mg,deg/s,deg/s,deg/s,mG,mG,mG\n" + body);
  EXPECT_NEAR(r.acc.v[0][0], 0.25 * 9.80665e-3, 1e-12);
  EXPECT_NEAR(r.mag[0].v[0][0], 1.75 * 0.1, 1e-12);
  EXPECT_THAT(r.notes.front(), HasSubstr("names are in lines 1 and 2"));
}

TEST(CsvDialect, a_file_without_a_header_needs_the_names) {
  const std::string body = rows(",", plain);
  const InputError error = test::error_of([&] { read_text(body); });
  EXPECT_EQ(error.line, 1);
  EXPECT_THAT(error.remedy, HasSubstr("--columns t,acc_x"));
  CsvOptions options;
  options.header = kDialectNames;
  expect_recording(read_text(body, options));
  options.header = "t,acc_x";
  EXPECT_THAT(test::error_of([&] { read_text(body, options); }).problem,
              HasSubstr("2 columns, this row has 10 fields"));
}

TEST(CsvDialect, separators_at_the_end_and_a_row_that_is_cut_off) {
  expect_recording(read_text(kDialectNames + "\n" + rows(",", plain, ",\n")));
  expect_recording(read_text(kDialectNames + ",\n" + rows(",", plain)));
  const Recording r = read_text(kDialectNames + "\n" + rows(",", plain) + "1.2,0.25,0.5");
  expect_recording(r);
  EXPECT_THAT(r.notes, Contains(HasSubstr("last row (line 32) is cut off")));
  const InputError error = test::error_of(
      [] { read_text(kDialectNames + "\n" + rows(",", plain) + "1.2,1\n" + rows(",", plain)); });
  EXPECT_EQ(error.line, kDialectRows + 2);
}

TEST(CsvDialect, times_of_the_day_and_dates) {
  const auto clock = [](const std::string& date, const std::string& end) {
    return kDialectNames + "\n" + rows(",", [&](int k, int c) {
             return c > 0 ? plain(k, c)
                          : fmt::format("{}12:00:{:06.3f}{}", date, 59 * 0 + 0.04 * k, end);
           });
  };
  for (const auto& [date, end] : {std::pair("", ""),
                                  {"2023-05-01T", "Z"},
                                  {"2023-05-01 ", ""},
                                  {"2023/05/01 ", "+02:00"},
                                  {"01.05.2023 ", ""}}) {
    const Recording r = read_text(clock(date, end));
    ASSERT_EQ(r.acc.size(), std::size_t(kDialectRows)) << date;
    EXPECT_NEAR(r.acc.t[20] - r.acc.t[0], 0.8, 1e-5);
  }
  EXPECT_EQ(clock_seconds("1970-01-02T00:00:01.5Z"), 86401.5);
  EXPECT_EQ(clock_seconds("1970-01-02T02:00:01+02:00"), 86401.0);
  EXPECT_EQ(clock_seconds("2000-03-01 00:00:00"), 951868800.0);
  for (const char* bad : {"12", "12:00", "2023-13-01T00:00:00", "25:00:00", "0.5", "a:b:c"}) {
    EXPECT_FALSE(clock_seconds(bad)) << bad;
  }
}

TEST(CsvDialect, one_sensor_a_row) {
  std::string text = "timestamp,sensor,x,y,z\n";
  for (int k = 0; k < kDialectRows; ++k) {
    for (const auto& [word, first] : {std::pair("ACC", 1), {"GYR", 4}, {"MAG", 7}, {"BARO", 1}}) {
      text += fmt::format("{},{},{},{},{}\n", 1700000000000000000 + 40000000LL * k, word,
                          number(k, first), number(k, first + 1), number(k, first + 2));
    }
  }
  const Recording r = read_text(text);
  expect_recording(r);
  EXPECT_THAT(r.notes.front(), HasSubstr("ignored: \"BARO\""));
}

TEST(CsvDialect, times_of_its_own_for_each_sensor) {
  std::string text =
      "acc_time,acc_x,acc_y,acc_z,gyr_time,gyr_x,gyr_y,gyr_z,mag_time,mag_x,mag_y,mag_z\n";
  for (int k = 0; k < kDialectRows; ++k) {
    for (int sensor = 0; sensor < 3; ++sensor) {
      const bool there = sensor != 2 || k < 10;
      text += sensor > 0 ? "," : "";
      text += there
                  ? fmt::format("{},{},{},{}", 0.04 * k + 0.001 * sensor, number(k, 3 * sensor + 1),
                                number(k, 3 * sensor + 2), number(k, 3 * sensor + 3))
                  : ",,,";
    }
    text += '\n';
  }
  const Recording r = read_text(text);
  EXPECT_EQ(r.acc.size(), std::size_t(kDialectRows));
  EXPECT_EQ(r.mag.at(0).size(), 10u);
  EXPECT_NEAR(r.gyr.t[1], 0.041, 1e-12);
  EXPECT_NEAR(r.mag[0].v[9][2], number(9, 9), 1e-12);
}

TEST(CsvDialect, labelled_numbers) {
  CsvOptions options;
  options.rate_hz = 25.0;
  const auto lines = [](const std::string& format) {
    std::string out = "Sensor ready\n";
    for (int k = 0; k < kDialectRows; ++k) {
      out +=
          fmt::format(fmt::runtime(format), number(k, 1), number(k, 2), number(k, 3), number(k, 4),
                      number(k, 5), number(k, 6), number(k, 7), number(k, 8), number(k, 9)) +
          "\r\n";
    }
    return out;
  };
  for (const char* format :
       {"ax:{},ay:{},az:{},gx:{},gy:{},gz:{},mx:{},my:{},mz:{}",
        "ax={} ay={} az={} gx={} gy={} gz={} mx={} my={} mz={}",
        "Accel X: {} Y: {} Z: {} m/s^2 Gyro X: {} Y: {} Z: {} rad/s Mag X: {} Y: {} Z: {} uT",
        "{{\"acc\":[{},{},{}],\"gyr\":[{},{},{}],\"mag\":[{},{},{}]}}",
        "{{\"acc\":{{\"x\":{},\"y\":{},\"z\":{}}},\"gyr\":{{\"x\":{},\"y\":{},\"z\":{}}},\"mag\":{{"
        "\"x\":{},\"y\":{},\"z\":{}}}}}",
        "Uni:{},{},{},{},{},{},{},{},{}"}) {
    SCOPED_TRACE(format);
    expect_recording(read_text(lines(format), options));
  }
  EXPECT_THAT(test::error_of([&] {
                read_text(lines("ax:{},ay:{},az:{},gx:{},gy:{},gz:{},mx:{},my:{},mz:{}"));
              }).remedy,
              HasSubstr("--rate"));
}

TEST(CsvDialect, raw_lines_of_motioncal_have_its_units) {
  CsvOptions options;
  options.rate_hz = 100.0;
  std::string text;
  for (int k = 0; k < kDialectRows; ++k)
    text += fmt::format("Raw:8192,0,{},16,0,-32,100,-50,{}\n", k, k);
  const Recording r = read_text(text, options);
  EXPECT_NEAR(r.acc.v[0][0], 9.80665, 1e-9);
  EXPECT_NEAR(r.gyr.v[0][2], -2.0 * M_PI / 180.0, 1e-9);
  EXPECT_NEAR(r.mag.at(0).v[3][0], 10.0, 1e-9);
  EXPECT_EQ(r.acc.size(), std::size_t(kDialectRows));
}

TEST(CsvDialect, seconds_and_nanoseconds_are_one_time) {
  std::string text =
      "header.stamp.sec,header.stamp.nanosec,linear_acceleration.x,linear_acceleration.y,"
      "linear_acceleration.z,angular_velocity.x,angular_velocity.y,angular_velocity.z,mag.x,mag.y,"
      "mag.z\n";
  for (int k = 0; k < kDialectRows; ++k) {
    text += fmt::format("{},{}", 1700000000 + (40 * k) / 1000, (40000000LL * k) % 1000000000);
    for (int c = 1; c < 10; ++c) text += "," + plain(k, c);
    text += '\n';
  }
  expect_recording(read_text(text));
}

TEST(CsvDialect, of_several_times_the_first_with_a_unit) {
  const std::string sensors = kDialectNames.substr(1);
  const auto fields = [](const std::string& before) {
    return [before](int k, int c) {
      return c == 0 ? fmt::format("{},{:.0f}", before, 1e6 * number(k, 0)) : plain(k, c);
    };
  };
  // mavlogdump: seconds since 1970 of the computer, and the autopilot's own.
  expect_recording(
      read_text("timestamp,TimeUS" + sensors + "\n" + rows(",", fields("1700000000"))));
  // SensorLog and MetaWear: how the date is written is no unit.
  for (const char* name : {"loggingTime(txt)", "time (+01:00)", "time (hh:mm:ss)"}) {
    expect_recording(read_text(std::string(name) + ",micros" + sensors + "\n" +
                               rows(",", fields("2024-05-01T10:00:00.000"))));
  }
  expect_recording(
      read_text("Time since start in ms " + sensors + "\n" + rows(",", [](int k, int c) {
                  return c == 0 ? fmt::format("{:.0f}", 1e3 * number(k, 0)) : plain(k, c);
                })));
}

TEST(CsvDialect, units_below_the_names_among_words_of_the_loggers_own) {
  // Shimmer: a row for spreadsheets, names, units.
  const std::string names =
      "Shimmer_A_Timestamp_Unix_CAL\tShimmer_A_Accel_WR_X_CAL\tShimmer_A_Accel_WR_Y_CAL\t"
      "Shimmer_A_Accel_WR_Z_CAL\tShimmer_A_Gyro_X_CAL\tShimmer_A_Gyro_Y_CAL\tShimmer_A_Gyro_Z_CAL\t"
      "Shimmer_A_Mag_X_CAL\tShimmer_A_Mag_Y_CAL\tShimmer_A_Mag_Z_CAL\n";
  const std::string units =
      "ms\tm/(s^2)\tm/(s^2)\tm/(s^2)\trad/s\trad/s\trad/s\tflux_x\tflux_y\tflux_z\n";
  CsvOptions options;
  options.mag_unit = 1.0;
  const Recording r =
      read_text("\"sep=\t\"\n" + names + units +
                    rows("\t",
                         [](int k, int c) {
                           return c == 0 ? fmt::format("{:.0f}", 1e3 * number(k, 0)) : plain(k, c);
                         }),
                options);
  expect_recording(r);
}

TEST(CsvName, knows_other_languages_topics_and_numbers) {
  for (const auto& [header, name] : {std::pair("Zeit (s)", "t"),
                                     {"%time", "t"},
                                     {"__time", "t"},
                                     {"TimeUS", "t"},
                                     {"field.header.stamp", "t"},
                                     {"Beschleunigung x (m/s^2)", "acc_x"},
                                     {"Acc\xC3\xA9l\xC3\xA9rom\xC3\xA8tre y", "acc_y"},
                                     {"Magnetfeld z (µT)", "mag_z"},
                                     {"/imu/data/linear_acceleration/x", "acc_x"},
                                     {"/imu/data/angular_velocity.z", "gyr_z"},
                                     {"xacc", "acc_x"},
                                     {"zmag", "mag_z"},
                                     {"IMU.GyrX", "gyr_x"},
                                     {"Acceleration X-axis (g)", "acc_x"},
                                     {"\xE5\x8A\xA0\xE9\x80\x9F\xE5\xBA\xA6X(g)", "acc_x"},
                                     {"accelerometer_m_s2_x", "acc_x"}}) {
    EXPECT_EQ(csv_name(header).name, name) << header;
  }
  EXPECT_NEAR(csv_name("magnetometer_ga_y").unit, 100.0, 1e-12);
  for (const char* other : {"bias_gyro_x", "acc_bias_x", "gravity_x", "user acceleration x",
                            "orientation_covariance_x", "angular_acceleration_x"}) {
    EXPECT_EQ(csv_name(other).name, "") << other;
  }
  EXPECT_THAT(with_axes_for_numbers({"a", "gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"}),
              testing::ElementsAre("a", "gyro_rad_x", "gyro_rad_y", "gyro_rad_z"));
  EXPECT_THAT(with_axes_for_numbers({"acc_1", "acc_2", "acc_3", "q[0]", "q[1]", "q[2]", "q[3]"}),
              testing::ElementsAre("acc_x", "acc_y", "acc_z", "q[0]", "q[1]", "q[2]", "q[3]"));
  EXPECT_EQ(csv_time_of("Accelerometer Timestamp (ns)"), "acc");
}

}  // namespace
}  // namespace magimu
