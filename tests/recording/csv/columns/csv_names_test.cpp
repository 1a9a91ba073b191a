// SPDX-License-Identifier: BSD-3-Clause
// What other loggers call their columns, and in which units they write.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "recording/csv/columns/csv_names.h"
#include "recording/csv/csv.h"
#include "recording/data/units.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::HasSubstr;

constexpr double kG = 9.80665, kDeg = M_PI / 180.0;

Recording read_named(const std::string& header, const std::string& row,
                     const CsvOptions& options = {}) {
  const test::TempFolder folder;
  return read_csv(folder.write("log.csv", header + "\n" + row + "\n"), options);
}

void expect_sample(const Recording& r, double acc, double gyr, double mag) {
  EXPECT_NEAR(r.acc.v.at(0)[0], 1 * acc, 1e-9);
  EXPECT_NEAR(r.acc.v.at(0)[2], 3 * acc, 1e-9);
  EXPECT_NEAR(r.gyr.v.at(0)[0], 4 * gyr, 1e-9);
  EXPECT_NEAR(r.mag.at(0).v.at(0)[2], 9 * mag, 1e-9);
}

TEST(OtherLoggers, phyphox) {
  expect_sample(
      read_named("Time (s),Acceleration x (m/s^2),Acceleration y (m/s^2),Acceleration z (m/s^2),"
                 "Gyroscope x (rad/s),Gyroscope y (rad/s),Gyroscope z (rad/s),"
                 "Magnetic field x (µT),Magnetic field y (µT),Magnetic field z (µT)",
                 "0,1,2,3,4,5,6,7,8,9"),
      1, 1, 1);
}

TEST(OtherLoggers, phyphox_without_gravity_is_used_only_where_nothing_better_is_there) {
  const std::string rest = ",gx,gy,gz,mx,my,mz",
                    linear =
                        ",Linear Acceleration x (m/s^2),Linear Acceleration y (m/s^2),Linear "
                        "Acceleration z (m/s^2)";
  const std::string with = ",Acceleration x (m/s^2),Acceleration y (m/s^2),Acceleration z (m/s^2)";
  EXPECT_EQ(read_named("Time (s)" + linear + with + rest, "0,-1,-1,-1,1,2,3,4,5,6,7,8,9").acc.v[0],
            Vector3(1, 2, 3));
}

TEST(OtherLoggers, sensor_logger_combined_in_one_file) {
  const Recording r = read_named(
      "time,seconds_elapsed,accelerometer_z,accelerometer_y,accelerometer_x,totalAcceleration_z,"
      "totalAcceleration_y,totalAcceleration_x,gyroscope_z,gyroscope_y,gyroscope_x,magnetometer_z,"
      "magnetometer_y,magnetometer_x,magnetometerUncalibrated_z,magnetometerUncalibrated_y,"
      "magnetometerUncalibrated_x",
      "1718030736872695300,0.5,0,0,0,3,2,1,6,5,4,99,99,99,9,8,7");
  expect_sample(r, 1, 1, 1);
  EXPECT_EQ(r.acc.t[0], 0.5);
  EXPECT_THAT(r.notes.at(0), HasSubstr("\"totalAcceleration_x\" as acc_x"));
  EXPECT_THAT(r.notes.at(0), HasSubstr("\"magnetometerUncalibrated_x\" as mag_x"));
}

TEST(OtherLoggers, physics_toolbox_has_g_forces) {
  expect_sample(
      read_named("time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz,Bx,By,Bz", "0,1,2,3,0,0,0,4,5,6,7,8,9"), kG, 1,
      1);
}

TEST(OtherLoggers, ros_as_csv) {
  expect_sample(read_named("time,field.linear_acceleration.x,field.linear_acceleration.y,"
                           "field.linear_acceleration.z,field.angular_velocity.x,"
                           "field.angular_velocity.y,field.angular_velocity.z,"
                           "field.magnetic_field.x,field.magnetic_field.y,field.magnetic_field.z",
                           "0,1,2,3,4,5,6,7,8,9"),
                1, 1, 1);
}

TEST(OtherLoggers, plain_loggers_with_units_in_their_names) {
  expect_sample(
      read_named("time_ms,acc_x_g,acc_y_g,acc_z_g,gyro_x_dps,gyro_y_dps,gyro_z_dps,mag_x_nT,"
                 "mag_y_nT,mag_z_nT",
                 "5,1,2,3,4,5,6,7,8,9"),
      kG, kDeg, 1e-3);
  const Recording r = read_named(
      "Timestamp [us],AccelX [mg],AccelY [mg],AccelZ [mg],GyroX [deg/s],GyroY [deg/s],GyroZ "
      "[deg/s],"
      "MagX [mG],MagY [mG],MagZ [mG]",
      "5,1,2,3,4,5,6,7,8,9");
  expect_sample(r, 1e-3 * kG, kDeg, 0.1);
  EXPECT_NEAR(r.acc.t[0], 5e-6, 1e-18);
  EXPECT_THAT(r.notes.at(1), HasSubstr("units converted: t in us"));
  EXPECT_THAT(r.notes.at(1), HasSubstr("gyr in deg/s"));
}

TEST(OtherLoggers, a_unit_that_is_given_wins_over_the_headers) {
  CsvOptions options;
  options.gyr_unit = 1.0;
  options.mag_unit = 100.0;
  expect_sample(
      read_named("t,acc_x,acc_y,acc_z,gyro_x_dps,gyro_y_dps,gyro_z_dps,mag_x_nT,mag_y_nT,mag_z_nT",
                 "5,1,2,3,4,5,6,7,8,9", options),
      1, 1, 100);
}

TEST(OtherLoggers, a_unit_that_is_not_known_is_an_error_and_not_a_guess) {
  const InputError error = test::error_of([] {
    read_named("t,acc_x (ft/s^2),acc_y (ft/s^2),acc_z (ft/s^2),gx,gy,gz,mx,my,mz",
               "0,1,2,3,4,5,6,7,8,9");
  });
  EXPECT_EQ(error.column, 2);
  EXPECT_THAT(error.problem, HasSubstr("\"ft/s^2\", which is not known"));
  EXPECT_THAT(error.remedy, HasSubstr("--unit acc=UNIT"));
}

TEST(Units, are_known_in_many_spellings_for_their_own_quantity_only) {
  EXPECT_EQ(unit_in_ours("mag", "mG"), 0.1);
  EXPECT_EQ(unit_in_ours("acc", "mG"), 1e-3 * kG);
  EXPECT_EQ(unit_in_ours("mag3", "Gauss"), 100.0);
  EXPECT_EQ(unit_in_ours("mag", "\xCE\xBCT"), 1.0);
  EXPECT_EQ(unit_in_ours("gyr", "\xC2\xB0/s"), kDeg);
  EXPECT_EQ(unit_in_ours("acc", "m/s\xC2\xB2"), 1.0);
  EXPECT_EQ(unit_in_ours("acc", "0.5"), 0.5);
  for (const char* bad : {"deg/s", "", "-1", "0", "nan", "inf", "1x"}) {
    EXPECT_FALSE(unit_in_ours("acc", bad)) << bad;
  }
}

TEST(CsvName, does_not_take_other_quantities_for_ours) {
  for (const char* header :
       {"gravity_x", "user acceleration x", "quat_x", "mag_accuracy", "time_zone", "temp_x",
        "x (m/s)", "(s)", "acc_x_5", "_", "acc_x (", "speed (m/s)", "mag_y#mag_z", "m_y#time",
        "mag.x 12345678901234567890"}) {
    EXPECT_EQ(csv_name(header).name, "") << header;
  }
}

}  // namespace
}  // namespace magimu
