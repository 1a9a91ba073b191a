// SPDX-License-Identifier: BSD-3-Clause
// Folders that phone apps export are read as one recording.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "recording/read.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

// So many rows of a time and three numbers.
std::string rows(const std::string& header, int count, const std::string& format) {
  std::string out = header + "\n";
  for (int k = 0; k < count; ++k) out += fmt::format(fmt::runtime(format), 0.01 * k) + "\n";
  return out;
}

TEST(PhoneFolder, of_phyphox_is_one_recording) {
  const test::TempFolder folder;
  for (const auto& [name, quantity, unit] : {std::tuple("Accelerometer", "Acceleration", "m/s^2"),
                                             {"Gyroscope", "Gyroscope", "rad/s"},
                                             {"Magnetometer", "Magnetic field", "µT"}}) {
    folder.write(std::string(name) + ".csv",
                 rows(fmt::format("\"Time (s)\",\"{0} x ({1})\",\"{0} y ({1})\",\"{0} z ({1})\"",
                                  quantity, unit),
                      30, "{:.2E},1.0E0,2.0E0,3.0E0"));
  }
  folder.write("Light.csv", "whatever");
  const Recording r = read_recording(folder.path(""));
  EXPECT_EQ(r.acc.size(), 30u);
  EXPECT_EQ(r.gyr.v[29], Vector3(1, 2, 3));
  EXPECT_EQ(r.mag.at(0).v[29], Vector3(1, 2, 3));
  EXPECT_NEAR(r.mag.at(0).t[29], 0.29, 1e-12);
  EXPECT_THAT(r.notes, Contains("mag is from Magnetometer.csv"));
}

TEST(PhoneFolder, of_sensor_logger_is_read_with_gravity_and_without_the_phones_corrections) {
  const test::TempFolder folder;
  const std::string header = "time,seconds_elapsed,z,y,x";
  const std::string row = "1718030736872695300,{:.2f},3,2,1",
                    other = "1718030736872695300,{:.2f},0,0,0";
  folder.write("TotalAcceleration.csv", rows(header, 30, row));
  folder.write("Accelerometer.csv", rows(header, 30, other));
  folder.write("Gyroscope.csv", rows(header, 40, row));
  folder.write("GyroscopeUncalibrated.csv", header + "\n");  // an empty one, as the app writes
  folder.write("Magnetometer.csv", rows(header, 30, other));
  folder.write("MagnetometerUncalibrated.csv", rows(header, 20, row));
  const Recording r = read_recording(folder.path(""));
  EXPECT_EQ(r.acc.v[0], Vector3(1, 2, 3));
  EXPECT_EQ(r.gyr.size(), 40u);
  EXPECT_EQ(r.mag.at(0).size(), 20u);
  EXPECT_EQ(r.mag.at(0).v[0], Vector3(1, 2, 3));
  EXPECT_THAT(r.mag_names, testing::ElementsAre("mag"));
  EXPECT_THAT(r.notes, Contains("acc is from TotalAcceleration.csv"));
}

TEST(PhoneFolder, with_a_sensor_missing_says_which) {
  const test::TempFolder folder;
  folder.write("Gyroscope.csv", rows("time,seconds_elapsed,z,y,x", 40, "1,{},3,2,1"));
  EXPECT_THAT(test::error_of([&] { read_recording(folder.path("")); }).problem,
              HasSubstr("no accelerometer; there are: gyr (Gyroscope.csv)"));
  EXPECT_THAT(test::error_of([] { read_recording(test::TempFolder().path("")); }).problem,
              HasSubstr("a folder without files"));
}

TEST(PhoneFolder, of_columns_that_are_just_axes_is_known_by_its_files_names) {
  const test::TempFolder folder;
  for (const auto& [name, unit] :
       {std::pair("Accelerometer", "m/s^2"), {"Gyroscope", "rad/s"}, {"Magnetometer", "µT"}}) {
    std::string text = rows(fmt::format("\"Time (s)\";\"X ({0})\";\"Y ({0})\";\"Z ({0})\"", unit),
                            30, "{:.2E};1.0E0;2.5E0;3.0E0");
    std::ranges::replace(text, '.', ',');
    folder.write(std::string(name) + ".csv", text);
  }
  const Recording r = read_recording(folder.path(""));
  EXPECT_EQ(r.acc.v[29], Vector3(1, 2.5, 3));
  EXPECT_EQ(r.mag.at(0).v[29], Vector3(1, 2.5, 3));
}

TEST(PhoneFolder, without_gravity_says_what_to_record) {
  const test::TempFolder folder;
  for (const char* name : {"Linear Accelerometer", "Gyroscope", "Magnetometer"}) {
    folder.write(std::string(name) + ".csv",
                 rows("\"Time (s)\",\"X\",\"Y\",\"Z\"", 30, "{:.2f},1,2,3"));
  }
  const InputError error = test::error_of([&] { read_recording(folder.path("")); });
  EXPECT_THAT(error.problem, HasSubstr("without gravity"));
  EXPECT_THAT(error.remedy, HasSubstr("Acceleration (with g)"));
}

TEST(PhoneFolder, names_the_file_and_line_that_cannot_be_read) {
  const test::TempFolder folder;
  const std::string header = "time,seconds_elapsed,z,y,x", row = "1,{},3,2,1";
  for (const char* name : {"TotalAcceleration.csv", "Gyroscope.csv", "Magnetometer.csv"}) {
    folder.write(name, rows(header, 40, row));
  }
  folder.write("Gyroscope.csv", rows(header, 40, row) + "1,0.41,oops,2,1\n");
  const InputError error = test::error_of([&] { read_recording(folder.path("")); });
  EXPECT_THAT(error.file, HasSubstr("Gyroscope.csv"));
  EXPECT_EQ(error.line, 42);
  EXPECT_EQ(error.column, 3);
}

}  // namespace
}  // namespace magimu
