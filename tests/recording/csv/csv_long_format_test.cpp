// SPDX-License-Identifier: BSD-3-Clause
// Tables with one sensor a row that hold more numbers than a time and three axes: which columns are
// the axes.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <string>

#include "recording/read.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr int kRows = 600;

double reading(int sensor, int k, int axis) {
  const double size = sensor == 0 ? 9.8 : sensor == 1 ? 1.5 : 45.0;
  return std::round(1e4 * size * std::sin(0.05 * k * (1 + 0.3 * sensor) + 2.1 * axis)) / 1e4;
}

// One row's fields of this sensor at this time.
using Row = std::function<std::string(int sensor, int k)>;

std::string axes(int sensor, int k, char separator = ',') {
  return fmt::format("{0:.4f}{3}{1:.4f}{3}{2:.4f}", reading(sensor, k, 0), reading(sensor, k, 1),
                     reading(sensor, k, 2), separator);
}

Recording read_rows(const std::string& header, const Row& row, const CsvOptions& options = {}) {
  std::string text = header;
  for (int k = 0; k < kRows; ++k) {
    for (int s = 0; s < 3; ++s) text += row(s, k) + "\n";
  }
  const test::TempFolder folder;
  return read_recording(folder.write("log.txt", text), options);
}

void expect_readings(const Recording& r) {
  ASSERT_EQ(r.mag.size(), 1u);
  for (int s = 0; s < 3; ++s) {
    const VectorSeries& series = s == 0 ? r.acc : s == 1 ? r.gyr : r.mag[0];
    ASSERT_EQ(series.size(), std::size_t(kRows)) << s;
    for (int k = 0; k < kRows; ++k) {
      EXPECT_NEAR(series.t[std::size_t(k)] - series.t[0], 0.02 * k, 1e-6);
      for (int a = 0; a < 3; ++a) {
        ASSERT_NEAR(series.v[std::size_t(k)][a], reading(s, k, a), 1e-9) << s << ' ' << k;
      }
    }
  }
}

constexpr const char* kWords[] = {"ACC", "GYR", "MAG"};

TEST(LongFormat, ends_with_an_accuracy_that_is_no_axis) {
  const Recording r = read_rows("", [](int s, int k) {
    return fmt::format("{:.2f},{},{},{}", 0.02 * k, kWords[s], axes(s, k), (k / 70 + s) % 4);
  });
  expect_readings(r);
  EXPECT_THAT(r.notes, Contains(HasSubstr("3, 4, 5 are read as x, y, z, not 6")));
}

TEST(LongFormat, without_more_columns_than_needed_says_nothing_of_them) {
  const Recording r = read_rows("", [](int s, int k) {
    return fmt::format("{:.2f},{},{}", 0.02 * k, kWords[s], axes(s, k));
  });
  expect_readings(r);
  EXPECT_THAT(r.notes, Not(Contains(HasSubstr("are read as x, y, z"))));
}

TEST(LongFormat, has_a_temperature_before_or_behind_the_axes) {
  const auto temperature = [](int s, int k) { return 30.0 + 0.1 * std::sin(0.7 * k + s); };
  expect_readings(read_rows("", [&](int s, int k) {
    return fmt::format("{:.2f},{},{},{:.2f}", 0.02 * k, kWords[s], axes(s, k), temperature(s, k));
  }));
  expect_readings(read_rows("", [&](int s, int k) {
    return fmt::format("{:.2f},{},{:.2f},{}", 0.02 * k, kWords[s], temperature(s, k), axes(s, k));
  }));
}

TEST(LongFormat, has_a_second_clock_and_a_counter) {
  expect_readings(read_rows("", [](int s, int k) {
    return fmt::format("{};{:.2f};{:.3f};{};{};3", kWords[s], 0.02 * k, 91234.5 + 0.02 * k,
                       3 * k + s, axes(s, k, ';'));
  }));
}

TEST(LongFormat, has_biases_that_only_uncalibrated_rows_have) {
  const Recording r = read_rows("", [](int s, int k) {
    const std::string row =
        fmt::format("{:.2f}\tTYPE_{}\t{}\t3", 0.02 * k, kWords[s], axes(s, k, '\t'));
    if (s != 2) return row;
    // Beside what the phone made of them stand the readings themselves, and its biases.
    return fmt::format(
        "{:.2f}\tTYPE_MAG\t1.5\t{:.1f}\t-2.5\t3\n{:.2f}\tTYPE_MAG_UNCALIBRATED\t{}"
        "\t12.5\t-3.5\t40.5\t3",
        0.02 * k, 0.5 * (k % 9), 0.02 * k, axes(s, k, '\t'));
  });
  expect_readings(r);
}

TEST(LongFormat, has_numbers_for_axes_in_its_header) {
  const auto row = [](int s, int k) {
    return fmt::format("{:.2f},{},{:.2f},{},{}", 0.02 * k, kWords[s], 2.0 * std::sin(k), axes(s, k),
                       k % 3);
  };
  expect_readings(read_rows("time,sensor,level,value0,value1,value2,accuracy\n", row));
  expect_readings(read_rows("time,sensor,level,v1,v2,v3,accuracy\n", row));
  expect_readings(read_rows("time,sensor,level,value_x,value_y,value_z,accuracy\n", row));
}

TEST(LongFormat, takes_its_time_from_the_column_that_is_told) {
  CsvOptions options;
  options.columns["moment"] = "t";
  expect_readings(read_rows(
      "sensor,moment,x,y,z\n",
      [](int s, int k) { return fmt::format("{},{:.2f},{}", kWords[s], 0.02 * k, axes(s, k)); },
      options));
}

TEST(LongFormat, of_an_accuracy_and_no_time_needs_a_rate) {
  const Row row = [](int s, int k) { return fmt::format("{},{},{}", kWords[s], axes(s, k), 3); };
  EXPECT_THAT(test::error_of([&] { read_rows("", row); }).remedy, HasSubstr("--rate"));
  CsvOptions options;
  options.rate_hz = 50.0;
  expect_readings(read_rows("", row, options));
}

TEST(LongFormat, of_get_sensor_data_is_timed_by_the_sensor) {
  std::string header = "% LogFile created by an app\n";
  header +=
      "% Magnetometer data: 'MAGN;AppTimestamp(s);SensorTimestamp(s);Mag_X(uT);Mag_Y(uT);"
      "Mag_Z(uT);Accuracy(integer)'\n";
  constexpr const char* kItsWords[] = {"ACCE", "GYRO", "MAGN"};
  expect_readings(read_rows(header, [&](int s, int k) {
    return fmt::format("{};{:.3f};{:.3f};{};3", kItsWords[s], 0.02 * k + 0.001 * (k % 5),
                       500.0 + 0.02 * k, axes(s, k, ';'));
  }));
}

TEST(LongFormat, of_one_axis_a_row_is_gathered) {
  expect_readings(read_rows("time,channel,value,quality\n", [](int s, int k) {
    std::string rows;
    for (int a = 0; a < 3; ++a) {
      rows += fmt::format("{}{:.2f},{}_{},{:.4f},{}", a > 0 ? "\n" : "", 0.02 * k, kWords[s],
                          "xyz"[a], reading(s, k, a), 1);
    }
    return rows;
  }));
}

TEST(CsvLongFormat, sensors_one_after_the_other_each_begin_anew_with_a_rate) {
  const auto text_of = [](int mags) {
    std::string text = "sensor,x,y,z\n";
    for (int s = 0; s < 3; ++s) {
      for (int k = 0; k < (s == 2 ? mags : kRows); ++k) {
        text += fmt::format("{},{}\n", s == 0 ? "ACC" : s == 1 ? "GYR" : "MAG", axes(s, k));
      }
    }
    return text;
  };
  CsvOptions options;
  options.rate_hz = 50.0;
  const test::TempFolder folder;
  const Recording r = read_recording(folder.write("log.csv", text_of(kRows)), options);
  expect_readings(r);
  EXPECT_EQ(r.acc.t.front(), 0.0);
  EXPECT_EQ(r.mag[0].t.front(), 0.0);
  EXPECT_NEAR(r.gyr.t.back(), 0.02 * (kRows - 1), 1e-9);
  EXPECT_THAT(r.notes, Contains(HasSubstr("one after the other")));
  const InputError error =
      test::error_of([&] { read_recording(folder.write("few.csv", text_of(kRows / 5)), options); });
  EXPECT_THAT(error.problem, HasSubstr("one rate does not say"));
}

}  // namespace
}  // namespace magimu
