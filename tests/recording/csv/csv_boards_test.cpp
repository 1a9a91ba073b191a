// SPDX-License-Identifier: BSD-3-Clause
// What boards print, terminals save and flight controllers' tools write: a sensor a line, a clock
// before each line, quotation marks, offsets beside the readings.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/csv/csv.h"
#include "recording/data/error.h"
#include "recording/live/sample_lines.h"
#include "recording/read.h"
#include "recording/several_files.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr int kCycles = 40;

Recording read_board(const std::string& content, const CsvOptions& options = {}) {
  return csv_recording(content, "log.csv", options);
}

CsvOptions at_rate(double rate_hz) {
  CsvOptions options;
  options.rate_hz = rate_hz;
  return options;
}

std::string board_numbers(int k, const std::string& separator = ",") {
  std::string out;
  for (int c = 1; c < 10; ++c) out += fmt::format("{}{}", c == 1 ? "" : separator, k + 0.5 * c);
  return out;
}

void expect_cycles(const Recording& r, double interval, std::size_t count = kCycles) {
  ASSERT_EQ(r.acc.size(), count);
  ASSERT_EQ(r.gyr.size(), count);
  ASSERT_EQ(r.mag.at(0).size(), count);
  for (std::size_t k = 0; k < count; ++k) {
    EXPECT_NEAR(r.acc.t[k] - r.acc.t[0], interval * double(k), 1e-6);
    EXPECT_NEAR(r.mag[0].t[k], r.acc.t[k], 1e-9);
    EXPECT_NEAR(r.acc.v[k][0], double(k) + 0.5, 1e-9);
    EXPECT_NEAR(r.gyr.v[k][1], double(k) + 2.5, 1e-9);
    EXPECT_NEAR(r.mag[0].v[k][2], double(k) + 4.5, 1e-9);
  }
}

std::string lines_of_one_sensor(int k) {
  return fmt::format(
      "Temp: 25.1 C\nAccel X: {} Y: 0 Z: 9 m/s^2\nGyro X: 0 Y: {} Z: 0 rad/s\n"
      "Mag X: 0 Y: 0 Z: {} uT\n\n",
      k + 0.5, k + 2.5, k + 4.5);
}

TEST(CsvBoards, a_rate_counts_cycles_of_lines_that_hold_one_sensor_each) {
  std::string text = "IMU found!\n";
  for (int k = 0; k < kCycles; ++k) text += lines_of_one_sensor(k);
  const InputError error = test::error_of([&] { read_board(text); });
  EXPECT_THAT(error.remedy, HasSubstr("--rate HZ"));
  const Recording r = read_board(text, at_rate(50.0));
  expect_cycles(r, 0.02);
  EXPECT_THAT(r.notes, Contains(HasSubstr("number of the cycle of lines")));
}

TEST(CsvBoards, a_line_that_is_lost_or_comes_seldom_shifts_no_cycle) {
  std::string text;
  for (int k = 0; k < kCycles; ++k) {
    std::string cycle = lines_of_one_sensor(k);
    if (k % 4 != 0) cycle.erase(cycle.find("Mag"));
    if (k == 7) cycle.erase(cycle.find("Gyro"), cycle.find("rad/s") + 6 - cycle.find("Gyro"));
    text += cycle;
  }
  const Recording r = read_board(text, at_rate(50.0));
  EXPECT_EQ(r.gyr.size(), std::size_t(kCycles - 1));
  EXPECT_EQ(r.mag.at(0).size(), std::size_t(kCycles / 4));
  EXPECT_NEAR(r.acc.t.back(), 0.02 * (kCycles - 1), 1e-9);
  EXPECT_NEAR(r.gyr.t.back(), 0.02 * (kCycles - 1), 1e-9);
  EXPECT_NEAR(r.mag[0].t[1], 0.08, 1e-9);
}

TEST(CsvBoards, so_do_rows_of_one_sensor_without_times) {
  std::string text, with_header = "sensor,x,y,z\n";
  for (int k = 0; k < kCycles; ++k) {
    text += fmt::format("ACC,{},0,9\nGYR,0,{},0\nMAG,0,0,{}\n", k + 0.5, k + 2.5, k + 4.5);
  }
  expect_cycles(read_board(text, at_rate(50.0)), 0.02);
  expect_cycles(read_board(with_header + text, at_rate(50.0)), 0.02);
  EXPECT_THAT(test::error_of([&] { read_board(text); }).remedy, HasSubstr("--rate HZ"));
}

TEST(CsvBoards, a_stream_counts_cycles_too) {
  std::string text;
  for (int k = 0; k < kCycles; ++k) text += lines_of_one_sensor(k);
  SampleLinesOptions options;
  options.csv.rate_hz = 50.0;
  SampleLines lines("test", options);
  lines.push(text);
  lines.finish();
  std::vector<double> t;
  for (const StreamSample& sample : lines.take()) {
    if (sample.mag.at(0)) t.push_back(sample.t);
  }
  ASSERT_EQ(t.size(), std::size_t(kCycles));
  EXPECT_NEAR(t.back(), 0.02 * (kCycles - 1), 1e-9);
}

const std::string kBoardNames = "ax,ay,az,gx,gy,gz,mx,my,mz";

std::string stamped(int k, const std::string& form) {
  return fmt::format(fmt::runtime(form), fmt::format("12:34:{:06.3f}", 10.0 + 0.02 * k));
}

TEST(CsvBoards, a_terminals_clock_before_each_line_is_the_time_where_there_is_no_other) {
  for (const std::string& form : std::vector<std::string>{"{} -> ", "[{}] ", "[2025-05-01 {}] "}) {
    std::string rows, timed, labelled;
    for (int k = 0; k < kCycles; ++k) {
      rows += stamped(k, form) + board_numbers(k) + "\n";
      timed += stamped(k, form) + fmt::format("{},", 812 + 20 * k) + board_numbers(k) + "\n";
      labelled += stamped(k, form) +
                  fmt::format("ax:{} ay:0 az:9 gx:0 gy:{} gz:0", k + 0.5, k + 2.5) +
                  fmt::format(" mx:0 my:0 mz:{}\n", k + 4.5);
    }
    const std::string boot = stamped(0, form) + "\n" + stamped(0, form) + "ets Jun  8 2016\n" +
                             stamped(0, form) + "sensor connected\n";
    expect_cycles(read_board(stamped(0, form) + kBoardNames + "\n" + rows), 0.02);
    expect_cycles(read_board(boot + stamped(0, form) + kBoardNames + "\n" + rows), 0.02);
    expect_cycles(read_board(labelled), 0.02);
    const Recording r = read_board(boot + stamped(0, form) + "time," + kBoardNames + "\n" + timed);
    expect_cycles(r, 0.02);
    EXPECT_THAT(r.notes, Contains(HasSubstr("clock is before each line: it is not used")));
    CsvOptions options;
    for (const std::string& columns : {kBoardNames, "t," + kBoardNames}) {
      options.header = columns;
      expect_cycles(read_board(rows, options), 0.02);
    }
    EXPECT_THAT(test::error_of([&] { read_board(rows); }).remedy, HasSubstr("--columns"));
  }
}

TEST(CsvBoards, a_header_that_comes_again_behind_the_clock_is_no_row) {
  std::string text;
  for (int k = 0; k < kCycles; ++k) {
    if (k % 10 == 0) text += stamped(k, "{} -> ") + kBoardNames + "\n";
    text += stamped(k, "{} -> ") + board_numbers(k) + "\n";
  }
  const Recording r = read_board(text);
  expect_cycles(r, 0.02);
  EXPECT_THAT(r.cautions, testing::IsEmpty());
}

TEST(CsvBoards, a_stream_with_a_terminals_clock) {
  std::string text = stamped(0, "{} -> ") + kBoardNames + "\n";
  for (int k = 0; k < kCycles; ++k) text += stamped(k, "{} -> ") + board_numbers(k) + "\n";
  SampleLines lines("test");
  lines.push(text);
  lines.finish();
  const std::vector<StreamSample> samples = lines.take();
  ASSERT_EQ(samples.size(), std::size_t(kCycles));
  EXPECT_NEAR(samples.back().t - samples.front().t, 0.02 * (kCycles - 1), 1e-6);
}

TEST(CsvBoards, separators_in_quotation_marks_separate_nothing) {
  const std::string header = "t," + kBoardNames + ",note\n";
  for (const std::string& note : std::vector<std::string>{
           R"("hand, left")", R"("he said ""go, now""")", R"("{""lat"": 52.1, ""lon"": 13.2}")"}) {
    std::string all, some;
    for (int k = 0; k < kCycles; ++k) {
      const std::string row = fmt::format("{:.2f},{},", 0.02 * k, board_numbers(k));
      all += row + note + "\n";
      some += row + (k == 3 ? note : "left") + "\n";
    }
    for (const std::string& rows : {all, some}) {
      const Recording r = read_board(header + rows);
      expect_cycles(r, 0.02);
      EXPECT_THAT(r.cautions, testing::IsEmpty());
    }
  }
}

TEST(CsvBoards, marks_between_groups_of_digits) {
  for (const auto& [number, mark] : {std::pair("1,036.664", ','),
                                     {"-38,032.5", ','},
                                     {"1,234,567", ','},
                                     {"1.036,664", '.'},
                                     {"1.234.567", '.'},
                                     {"1,036", '\0'},
                                     {"1.036", '\0'},
                                     {"1,03,664.5", '\0'},
                                     {"1234,567.8", '\0'},
                                     {"", '\0'},
                                     {"-", '\0'}}) {
    EXPECT_EQ(group_mark(number), mark) << number;
  }
  const auto rows = [](char separator, char mark, char point, bool quoted) {
    std::string out = "time_ms,ax,ay,az,gx,gy,gz,mx_nT,my_nT,mz_nT\n";
    std::ranges::replace(out, ',', separator);
    for (int k = 0; k < kCycles; ++k) {
      out += fmt::format("{}", 20 * k);
      for (int c = 1; c < 10; ++c) {
        const double value = k + 0.5 * c;
        const std::string small = fmt::format("{}{}{:03d}", int(value), point,
                                              int(std::lround(1e3 * (value - int(value)))));
        const int thousandths = int(std::lround(1e3 * value));
        const std::string large =
            thousandths < 1000
                ? fmt::format("{}{}0", thousandths, point)
                : fmt::format("{}{}{:03d}{}0", thousandths / 1000, mark, thousandths % 1000, point);
        const std::string field = c < 7 ? small : large;
        out += separator + (quoted ? '"' + field + '"' : field);
      }
      out += '\n';
    }
    return out;
  };
  expect_cycles(read_board(rows(',', ',', '.', true)), 0.02);
  expect_cycles(read_board(rows(';', ',', '.', false)), 0.02);
  expect_cycles(read_board(rows(';', '.', ',', false)), 0.02);
}

std::string compass_rows(bool offsets, bool two) {
  std::string out = "timestamp,TimeUS,I,MagX,MagY,MagZ";
  out += offsets ? ",OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health\n" : ",Health\n";
  for (int k = 0; k < kCycles; ++k) {
    for (int i = 0; i < (two ? 2 : 1); ++i) {
      // Measured (0, 0, 10 k + 45) mG.
      out +=
          fmt::format("1700000000.{:02d},{},{},{},{},{}", k, 5000000 + 20000 * k, i,
                      offsets ? 107 : 7 * i, offsets ? -200 : 0, 10 * k + 45 + (offsets ? 300 : 0));
      out += offsets ? ",100,-200,300,7,0,0,1\n" : ",1\n";
    }
  }
  return out;
}

std::string imu_rows() {
  std::string out = "timestamp,TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n";
  for (int k = 0; k < kCycles; ++k) {
    out += fmt::format("1700000000.{:02d},{},0,0,{},0,{},0,9\n", k, 5000000 + 20000 * k, k + 2.5,
                       k + 0.5);
  }
  return out;
}

TEST(CsvBoards, offsets_that_ardupilot_added_are_taken_off) {
  for (const bool offsets : {true, false}) {
    for (const bool two : {false, true}) {
      const test::TempFolder folder;
      folder.write("MAG.csv", compass_rows(offsets, two));
      folder.write("IMU.csv", imu_rows());
      const Recording r = read_recording(folder.path(""));
      expect_cycles(r, 0.02);
      EXPECT_LT((r.mag[0].v[0] - Vector3(0, 0, 4.5)).norm(), 1e-9);
      EXPECT_THAT(r.notes, Contains(HasSubstr(offsets ? "taken off" : "this file lacks them")));
      const std::string others = fmt::format("column I is not 0): {}", kCycles);
      const bool told = std::ranges::any_of(
          r.notes, [&](const std::string& note) { return note.find(others) != note.npos; });
      EXPECT_EQ(told, two);
    }
  }
}

TEST(CsvBoards, offsets_in_the_text_of_mavlogdump_are_taken_off) {
  std::string text;
  for (int k = 0; k < kCycles; ++k) {
    const std::string head = fmt::format("2023-11-14 22:13:{:05.2f}: ", 0.02 * k);
    const std::string time = fmt::format("TimeUS : {}, I : 0", 5000000 + 20000 * k);
    text += head + "IMU {" + time +
            fmt::format(", GyrX : 0, GyrY : {}, GyrZ : 0, AccX : {}, AccY : 0, AccZ : 9}}\n",
                        k + 2.5, k + 0.5);
    text += head + "MAG {" + time +
            fmt::format(
                ", MagX : 100, MagY : -200, MagZ : {}, OfsX : 100, OfsY : -200, OfsZ : "
                "300}}\n",
                10 * k + 345);
  }
  expect_cycles(read_board(text), 0.02);
}

TEST(CsvBoards, of_a_corrected_and_an_uncalibrated_magnetometer_the_latter_is_read) {
  for (const auto& [measured, corrected] :
       {std::pair("magnetometer_uncalibrated_", "magnetometer_"),
        {"mag_uncal_", "mag_"},
        {"uncalibrated_magnetic_field_", "magnetic_field_"}}) {
    for (const bool first : {true, false}) {
      const std::string a = first ? measured : corrected, b = first ? corrected : measured;
      std::string text = "t,ax,ay,az,gx,gy,gz";
      for (const std::string& sensor : {a, b}) {
        for (const char* axis : {"x", "y", "z"}) text += "," + sensor + axis;
      }
      text += '\n';
      for (int k = 0; k < kCycles; ++k) {
        const std::string m = fmt::format(",0,0,{}", k + 4.5), c = ",1,1,1";
        text += fmt::format("{:.2f},{},0,9,0,{},0", 0.02 * k, k + 0.5, k + 2.5) +
                (first ? m + c : c + m) + "\n";
      }
      const Recording r = read_board(text);
      expect_cycles(r, 0.02);
      // The remedy takes the other one.
      EXPECT_THAT(r.notes, Contains(HasSubstr(fmt::format("--map mag_x={}x", corrected))));
      CsvOptions options;
      for (const char* axis : {"x", "y", "z"}) {
        options.columns[std::string(corrected) + axis] = std::string("mag_") + axis;
      }
      EXPECT_EQ(read_board(text, options).mag.at(0).v[5], Vector3(1, 1, 1));
    }
  }
}

TEST(CsvBoards, files_are_known_by_a_sensors_word_before_rates_and_versions) {
  EXPECT_EQ(sensor_of_name("Board_2023-05-01T12.00.00.000_C8F4_Gyroscope_50.000Hz_1.5.0.csv"),
            "gyr");
  EXPECT_EQ(sensor_of_name("Magnetometer_50.000Hz.csv"), "mag");
  EXPECT_EQ(sensor_of_name("AngularVelocity.csv"), "gyr");
  EXPECT_EQ(sensor_of_name("Accelerometer 2025-05-01.csv"), "acc");
  EXPECT_EQ(sensor_of_name("Accelerometer (1).csv"), "acc");
  EXPECT_EQ(sensor_of_name("gyro_data.csv"), "gyr");
  EXPECT_EQ(sensor_of_name("magnetometer.data.csv"), "mag");
  EXPECT_EQ(sensor_of_name("RotationRate.csv"), "gyr");
  EXPECT_EQ(sensor_of_name("gyro_bias.csv"), "");
  EXPECT_EQ(sensor_of_name("2023_05_01.csv"), "");
}

TEST(CsvBoards, a_unit_behind_the_first_axis_is_meant_for_all) {
  const Recording r = read_board(
      "t,acc_x (g),acc_y,acc_z,gyr_x,gyr_y,gyr_z [deg/s],mag_x (mG),mag_y (uT),mag_z\n"
      "0,1,1,1,180,180,180,10,10,10\n0.01,1,1,1,180,180,180,10,10,10\n");
  EXPECT_EQ(r.acc.v[0], Vector3::Constant(9.80665));
  EXPECT_NEAR(r.gyr.v[0][0], M_PI, 1e-12);
  EXPECT_NEAR(r.gyr.v[0][2], M_PI, 1e-12);
  EXPECT_NEAR(r.mag.at(0).v[0][0], 1.0, 1e-12);
  EXPECT_NEAR(r.mag.at(0).v[0][1], 10.0, 1e-12);  // has one of its own
}

TEST(CsvBoards, the_names_of_euroc) {
  std::string text =
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
      "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2],mag_x,mag_y,mag_z\n";
  for (int k = 0; k < kCycles; ++k) {
    text += fmt::format("{},0,{},0,{},0,9,0,0,{}\n", 1403636579758555392 + 20'000'000LL * k,
                        k + 2.5, k + 0.5, k + 4.5);
  }
  expect_cycles(read_board(text), 0.02);
}

TEST(CsvBoards, a_header_that_never_ends_takes_no_time) {
  std::string text = "1{\"se";
  for (int i = 0; i < 20000; ++i) text += ", bias_x_acc y\\ z: 0.01";
  EXPECT_THROW(read_board(text), InputError);
}

TEST(CsvBoards, months_have_names) {
  EXPECT_NEAR(*clock_seconds("01-May-2025 12:34:56.250"), *clock_seconds("2025-05-01 12:34:56.250"),
              1e-9);
  EXPECT_NEAR(*clock_seconds("7 dec 2024 00:00:01"), *clock_seconds("2024-12-07 00:00:01"), 1e-9);
  EXPECT_FALSE(clock_seconds("01-Foo-2025 12:34:56"));
  EXPECT_FALSE(clock_seconds("01-anf-2025 12:34:56"));
}

// Texts of loggers that new users tried: they are read as they are, or refused with a remedy.
namespace trials {

constexpr int kRows = 60;

template <class Text>
Recording read_lines(const std::string& head, const Text& text) {
  const test::TempFolder folder;
  std::string all = head;
  for (int k = 0; k < kRows; ++k) all += text(k);
  return read_recording(folder.write("log.txt", all));
}

void expect_rows(const Recording& r) {
  ASSERT_EQ(r.acc.size(), std::size_t(kRows));
  ASSERT_EQ(r.gyr.size(), r.acc.size());
  ASSERT_EQ(r.mag.at(0).size(), r.acc.size());
  for (std::size_t k = 0; k < r.acc.size(); ++k) {
    EXPECT_NEAR(r.acc.t[k] - r.acc.t[0], 0.02 * double(k), 1e-6);
    EXPECT_NEAR(r.acc.v[k][0], double(k) + 0.5, 1e-9);
    EXPECT_NEAR(r.gyr.v[k][1], double(k) + 2.5, 1e-9);
    EXPECT_NEAR(r.mag[0].v[k][2], double(k) + 4.5, 1e-9);
  }
}

TEST(CsvTrials, ms_before_a_colon_is_a_name_and_no_unit) {
  expect_rows(read_lines("", [](int k) {
    return fmt::format("ax:{}\tay:0\taz:9\tgx:0\tgy:{}\tgz:0\tmx:0\tmy:0\tmz:{}\tms:{}\n", k + 0.5,
                       k + 2.5, k + 4.5, 20 * k);
  }));
}

TEST(CsvTrials, a_number_in_brackets_before_all_others_is_the_time) {
  expect_rows(read_lines("", [](int k) {
    return fmt::format("I ({}) imu: acc {} 0 9 gyr 0 {} 0 mag 0 0 {}\n", 312 + 20 * k, k + 0.5,
                       k + 2.5, k + 4.5);
  }));
  expect_rows(read_lines("", [](int k) {
    return fmt::format(
        "[{0}] Accel X: {1} Y: 0 Z: 9 m/s^2\n[{0}] Gyro X: 0 Y: {2} Z: 0 rad/s\n"
        "[{0}] Mag X: 0 Y: 0 Z: {3} uT\n",
        20 * k, k + 0.5, k + 2.5, k + 4.5);
  }));
}

TEST(CsvTrials, lines_of_influxdb_end_with_their_time) {
  expect_rows(read_lines("", [](int k) {
    return fmt::format("imu,device=a ax={},ay=0,az=9,gx=0,gy={},gz=0,mx=0,my=0,mz={} {}\n", k + 0.5,
                       k + 2.5, k + 4.5, 1714744931000000000LL + 20'000'000LL * k);
  }));
}

TEST(CsvTrials, units_behind_a_slash_and_with_superscripts) {
  expect_rows(read_lines(
      "time / s,a_x / m·s⁻²,a_y / m·s⁻²,a_z / m·s⁻²,ω_x / rad·s⁻¹,ω_y / rad·s⁻¹,ω_z / rad·s⁻¹,"
      "B_x / µT,B_y / µT,B_z / µT\n",
      [](int k) {
        return fmt::format("{:.2f},{},0,9,0,{},0,0,0,{}\n", 0.02 * k, k + 0.5, k + 2.5, k + 4.5);
      }));
  EXPECT_NEAR(csv_name("ω_x / °·s⁻¹").unit, M_PI / 180.0, 1e-12);
  EXPECT_EQ(csv_name("RollRate").name, "gyr_x");
  EXPECT_EQ(csv_name("yaw rate (deg/s)").name, "gyr_z");
  EXPECT_EQ(csv_name("pitch").name, "");
}

// Garmin's FitCSVTool: several samples in a message, and messages of its own for each sensor.
TEST(CsvTrials, messages_of_a_fit_file) {
  const auto message = [](int k, const char* name, const char* field, const char* unit,
                          const std::string& x, const std::string& y, const std::string& z) {
    return fmt::format(
        "Data,3,{0},timestamp,\"{1}\",s,timestamp_ms,\"{2}\",ms,sample_time_offset,\"0|20|40\",ms,"
        "{3}x,\"{5}\",{4},{3}y,\"{6}\",{4},{3}z,\"{7}\",{4},\n",
        name, 1000000000 + 60 * k / 1000, 60 * k % 1000, field, unit, x, y, z);
  };
  const auto three = [](double first) {
    return fmt::format("{}|{}|{}", first, first + 1.0, first + 2.0);
  };
  std::string text =
      "Type,Local Number,Message,Field 1,Value 1,Units 1,Field 2,Value 2,Units 2\n"
      "Definition,0,file_id,type,1,,manufacturer,1,\nData,0,file_id,type,\"4\",,,,\n";
  for (int k = 0; k < kRows / 3; ++k) {
    text +=
        message(k, "accelerometer_data", "calibrated_accel_", "g", three(3 * k), "0|0|0", "9|9|9");
    text +=
        message(k, "gyroscope_data", "calibrated_gyro_", "deg/s", "0|0|0", three(3 * k), "0|0|0");
    text += message(k, "magnetometer_data", "calibrated_mag_", "G", "0|0|0", "0|0|0", three(3 * k));
    text += "Data,5,record,timestamp,\"1000000000\",s,heart_rate,\"80\",bpm\n";
  }
  const test::TempFolder folder;
  const Recording r = read_recording(folder.write("activity.csv", text));
  ASSERT_EQ(r.acc.size(), std::size_t(kRows));
  ASSERT_EQ(r.mag.at(0).size(), std::size_t(kRows));
  for (std::size_t k = 0; k < r.acc.size(); ++k) {
    EXPECT_NEAR(r.acc.t[k] - r.acc.t[0], 0.02 * double(k), 1e-6);
    EXPECT_NEAR(r.acc.v[k][0], 9.80665 * double(k), 1e-9);
    EXPECT_NEAR(r.gyr.v[k][1], M_PI / 180.0 * double(k), 1e-9);
    EXPECT_NEAR(r.mag[0].v[k][2], 100.0 * double(k), 1e-9);
  }
}

TEST(CsvTrials, what_is_no_recording_is_named_with_the_remedy) {
  const test::TempFolder folder;
  const auto answer = [&folder](const std::string& text) -> std::string {
    try {
      read_recording(folder.write("log.txt", text));
    } catch (const InputError& e) {
      return e.problem + "; " + e.remedy;
    }
    return "";
  };
  EXPECT_THAT(answer("INSERT INTO imu VALUES(0.0,1,2,3);\n"), HasSubstr("-header -csv"));
  EXPECT_THAT(answer("header:\n  stamp:\n    sec: 1\n"), HasSubstr("ros2 bag record"));
  EXPECT_THAT(answer("#group,false,false\n,result,table,_time,_value,_field\n"),
              HasSubstr("pivot"));
  EXPECT_THAT(answer(std::string("\x0E\x20\x54\x08\x10\x00\x00\x00.FIT\x01\x02", 14)),
              HasSubstr("FitCSVTool"));
  EXPECT_THAT(answer("Type,Local Number,Message,Field 1,Value 1,Units 1\n"),
              HasSubstr("accelerometer_data"));
}

}  // namespace trials

}  // namespace
}  // namespace magimu
