// SPDX-License-Identifier: BSD-3-Clause
// Folders with files of several devices, and of several accelerometers of one.
#include "recording/devices_of_files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>

#include "recording/read.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

// A file of one sensor that reads (value, 2, 3).
void write_sensor(const test::TempFolder& folder, const std::string& name, int value) {
  std::string text = "time (s),x,y,z\n";
  for (int k = 0; k < 30; ++k) text += fmt::format("{:.2f},{},2,3\n", 0.01 * k, value);
  folder.write(name, text);
}

TEST(DevicesOfFiles, are_told_by_their_own_word_in_the_names) {
  EXPECT_TRUE(differ_in_device("Unit_2023-05-01T12.00_C8F4_Accelerometer_50.000Hz_1.5.csv",
                               "Unit_2023-05-01T12.01_D1A2_Gyroscope_25.000Hz_1.5.csv"));
  EXPECT_TRUE(differ_in_device("IMU1_acc.csv", "IMU2_mag.csv"));
  EXPECT_TRUE(differ_in_device("D422CD000001.csv", "D422CD000002.csv"));
  EXPECT_FALSE(differ_in_device("Unit_12.00.01_C8F4_acc.csv", "Unit_12.00.07_C8F4_gyr.csv"));
  EXPECT_FALSE(differ_in_device("phone_acc.csv", "compass_mag.csv"));
  EXPECT_FALSE(differ_in_device("Accelerometer.csv", "Gyroscope.csv"));
  EXPECT_FALSE(differ_in_device("log_7_sensor_accel_0.csv", "log_7_vehicle_magnetometer_0.csv"));
  EXPECT_FALSE(differ_in_device("1_acc.csv", "2_gyr.csv"));
}

TEST(DevicesOfFiles, the_one_with_all_sensors_is_read_and_another_one_may_be_chosen) {
  const test::TempFolder folder;
  for (const char* sensor : {"acc", "gyr"}) {
    write_sensor(folder, fmt::format("Unit_C8F4_{}.csv", sensor), 1);
  }
  for (const char* sensor : {"acc", "gyr", "mag"}) {
    write_sensor(folder, fmt::format("Unit_D1A2_{}.csv", sensor), 2);
    write_sensor(folder, fmt::format("Unit_E0B3_{}.csv", sensor), 3);
  }
  const Recording r = read_recording(folder.path(""));
  for (const VectorSeries& series : {r.acc, r.gyr, r.mag.at(0)}) EXPECT_EQ(series.v[0].x(), 2.0);
  EXPECT_THAT(r.notes, Contains(AllOf(HasSubstr("another device"), HasSubstr("Unit_C8F4_acc.csv"),
                                      HasSubstr("Unit_E0B3_mag.csv"), HasSubstr("--sensor"))));
  CsvOptions options;
  options.sensors = {"Unit_E0B3_gyr.csv"};
  const Recording other = read_recording(folder.path(""), options);
  for (const VectorSeries& series : {other.acc, other.gyr, other.mag.at(0)}) {
    EXPECT_EQ(series.v[0].x(), 3.0);
  }
}

TEST(DevicesOfFiles, of_which_none_has_all_sensors_are_joined_only_where_all_are_chosen) {
  const test::TempFolder folder;
  write_sensor(folder, "Unit_C8F4_acc.csv", 1);
  write_sensor(folder, "Unit_C8F4_gyr.csv", 1);
  write_sensor(folder, "Unit_D1A2_mag.csv", 2);
  const InputError error = test::error_of([&] { read_recording(folder.path("")); });
  EXPECT_THAT(error.problem, AllOf(HasSubstr("accelerometer and the gyroscope"),
                                   HasSubstr("magnetometer is of another one")));
  EXPECT_THAT(error.remedy, HasSubstr("--sensor Unit_D1A2_mag.csv"));
  CsvOptions options;
  options.sensors = {"Unit_C8F4_acc.csv", "Unit_C8F4_gyr.csv", "Unit_D1A2_mag.csv"};
  EXPECT_EQ(read_recording(folder.path(""), options).mag.size(), 1u);
}

TEST(DevicesOfFiles, an_accelerometer_of_high_range_is_not_preferred) {
  const test::TempFolder folder;
  std::string inertial = "t,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z\n", high = "t,acc_x,acc_y,acc_z\n";
  for (int k = 0; k < 30; ++k) {
    inertial += fmt::format("{:.2f},0,0,0,0,0,9.8\n", 0.01 * k);
    high += fmt::format("{:.2f},0,0,12\n", 0.01 * k);
  }
  folder.write("Inertial.csv", inertial);
  folder.write("HighGAccelerometer.csv", high);
  write_sensor(folder, "Magnetometer.csv", 20);
  EXPECT_EQ(read_recording(folder.path("")).acc.v[0].z(), 9.8);
}

}  // namespace
}  // namespace magimu
