// SPDX-License-Identifier: BSD-3-Clause
#include "archive/inventory/file_names.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "archive/inventory/device_readings.h"

namespace magimu {
namespace {

using testing::ElementsAre;
using Names = std::vector<std::string>;

Names usual_devices(const Names& shown) { return device_readings(shown, "fleet").front().device; }

TEST(FileNames, words_are_without_dates_times_and_numbers_at_the_ends) {
  EXPECT_EQ(words_of_name("2024-01-10_alpha"), "alpha");
  EXPECT_EQ(words_of_name("20240110_142203_alpha"), "alpha");
  EXPECT_EQ(words_of_name("alpha_2024-01-10_rear"), "alpha_rear");
  EXPECT_EQ(words_of_name("log_3_2024-1-10-14-22-03"), "log");
  EXPECT_EQ(words_of_name("01_slow_rotation_A"), "slow_rotation_A");
  EXPECT_EQ(words_of_name("b7-02"), "b7");
  EXPECT_EQ(words_of_name("imu_12"), "imu");
  EXPECT_EQ(words_of_name("14_22_03"), "");
  EXPECT_EQ(words_of_name("MPU6050RM3100"), "MPU6050RM3100");
  EXPECT_EQ(words_without_digits("2024-01-10_flight7"), "flight");
}

TEST(FileNames, dates_are_those_of_the_file_and_else_of_its_folder) {
  EXPECT_EQ(date_in_path("a/2024-01-10_flight1.csv"), "2024-01-10");
  EXPECT_EQ(date_in_path("2024-01-10_14-22-03.csv"), "2024-01-10T14:22:03");
  EXPECT_EQ(date_in_path("x_20240110_1422.csv"), "2024-01-10T14:22");
  EXPECT_EQ(date_in_path("2024-02-29/a.csv"), "2024-02-29");
  EXPECT_EQ(date_in_path("2023-02-29/a.csv"), "");  // there was no such day
  EXPECT_EQ(date_in_path("120240110.csv"), "");
  EXPECT_EQ(date_in_path("b1-1.csv"), "");
}

TEST(DeviceReadings, dates_and_numbers_are_no_devices) {
  EXPECT_THAT(usual_devices({"2024-01-10_alpha.csv", "2024-01-11_beta.csv", "2024-02-10_alpha.csv",
                             "2024-02-11_beta.csv"}),
              ElementsAre("alpha", "beta", "alpha", "beta"));
  EXPECT_THAT(usual_devices({"2024-01-10_flight1.csv", "2024-01-11_flight2.csv"}),
              ElementsAre("flight", "flight"));
  EXPECT_THAT(usual_devices({"2024-01-10.csv", "2024-01-11.csv"}), ElementsAre("fleet", "fleet"));
  EXPECT_THAT(usual_devices({"2024-01-10/alpha.csv", "2024-01-10/beta.csv", "2024-01-11/alpha.csv",
                             "2024-01-11/beta.csv"}),
              ElementsAre("alpha", "beta", "alpha", "beta"));
}

TEST(DeviceReadings, a_folder_is_a_device_where_its_files_are_only_numbered) {
  EXPECT_THAT(
      usual_devices({"drone1/log1.csv", "drone1/log2.csv", "drone2/log1.csv", "drone2/log2.csv"}),
      ElementsAre("drone1", "drone1", "drone2", "drone2"));
  EXPECT_THAT(usual_devices({"2024/drone1/log1.csv", "2024/drone2/log1.csv"}),
              ElementsAre("drone1", "drone2"));
  EXPECT_THAT(usual_devices({"alpha/2024-01-10_flight1.csv", "alpha/2024-01-11_flight2.csv"}),
              ElementsAre("alpha", "alpha"));
}

TEST(DeviceReadings, offers_the_files_names_as_another_reading) {
  const std::vector<DeviceReading> all = device_readings(
      {"drone1/log1.csv", "drone1/log2.csv", "drone2/log1.csv", "drone2/log2.csv"}, "fleet");
  EXPECT_TRUE(std::ranges::any_of(all, [](const DeviceReading& r) {
    return r.device == Names{"log1", "log2", "log1", "log2"};
  }));
}

}  // namespace
}  // namespace magimu
