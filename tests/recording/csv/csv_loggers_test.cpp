// SPDX-License-Identifier: BSD-3-Clause
// Files as the programs of makers of sensors write them: their names for the time, their units,
// their characters, a sensor's readings beside another one's.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <iconv.h>

#include <cmath>
#include <functional>

#include "recording/csv/columns/csv_names.h"
#include "recording/csv/csv.h"
#include "recording/data/units.h"
#include "recording/read.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr int kLoggedRows = 60;
constexpr double kG = 9.80665, kDeg = M_PI / 180.0;

// Readings that rise and fall, as those of a turned board do.
double reading(int k, int column) {
  return std::round(1000.0 * (3.0 * std::sin(0.7 * k + column) + column)) / 1000.0;
}

std::string numbers(int k, const std::string& separator = ",", int first = 0, int count = 9) {
  std::string out;
  for (int c = first; c < first + count; ++c) {
    out += fmt::format("{}{}", c == first ? "" : separator, reading(k, c));
  }
  return out;
}

// A header, and a row for each k.
std::string table(const std::string& header, const std::function<std::string(int)>& row) {
  std::string out = header + "\n";
  for (int k = 0; k < kLoggedRows; ++k) out += row(k) + "\n";
  return out;
}

struct InOurs {
  double acc = 1.0, gyr = 1.0, mag = 1.0;
};

// All readings, every 10 ms.
void expect_logged(const Recording& r, const InOurs& unit = {}) {
  ASSERT_EQ(r.acc.size(), std::size_t(kLoggedRows));
  ASSERT_EQ(r.gyr.size(), std::size_t(kLoggedRows));
  ASSERT_EQ(r.mag.at(0).size(), std::size_t(kLoggedRows));
  for (int k = 0; k < kLoggedRows; ++k) {
    const auto i = std::size_t(k);
    EXPECT_NEAR(r.acc.t[i] - r.acc.t[0], 0.01 * k, 1e-5);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(r.acc.v[i][axis], unit.acc * reading(k, axis), 1e-6);
      EXPECT_NEAR(r.gyr.v[i][axis], unit.gyr * reading(k, 3 + axis), 1e-6);
      EXPECT_NEAR(r.mag[0].v[i][axis], unit.mag * reading(k, 6 + axis), 1e-6);
    }
  }
}

Recording read_log(const std::string& content, const CsvOptions& options = {}) {
  return csv_recording(content, "log.csv", options);
}

TEST(Loggers, have_seconds_and_what_is_beyond_them_in_a_column_that_only_its_name_tells) {
  // Advanced Navigation
  const Recording r = read_log(
      table("Unix Time,Microseconds,Accelerometer X (m/s/s),Accelerometer Y (m/s/s),"
            "Accelerometer Z (m/s/s),Gyroscope X (rad/s),Gyroscope Y (rad/s),Gyroscope Z (rad/s),"
            "Magnetometer X (mG),Magnetometer Y (mG),Magnetometer Z (mG)",
            [](int k) {
              const int us = 700000 + 10000 * k;
              return fmt::format("{},{},{}", 1709648527 + us / 1000000, us % 1000000, numbers(k));
            }));
  expect_logged(r, {1.0, 1.0, 0.1});
}

TEST(Loggers, have_microseconds_beside_seconds_that_are_the_whole_time_again) {
  const Recording r =
      read_log(table("Time,us,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z", [](int k) {
        return fmt::format("{},{},{}", 0.01 * k, 10000 * k, numbers(k));
      }));
  expect_logged(r);
}

TEST(Loggers, call_a_temperature_t_and_the_time_by_its_form) {
  // Unicleo
  const Recording r = read_log(
      table("hh:mm:ss.ms,P [mB],T ['C],A.X [mg],A.Y [mg],A.Z [mg],G.X [mdps],G.Y [mdps],G.Z [mdps],"
            "M.X [mgauss],M.Y [mgauss],M.Z [mgauss]",
            [](int k) { return fmt::format("14:22:07.{:02}0,1013.2,25.1,{}", k, numbers(k)); }));
  expect_logged(r, {1e-3 * kG, 1e-3 * kDeg, 0.1});
}

TEST(Loggers, give_the_time_a_name_of_their_own) {
  // OpenLog Artemis: a date, a time of the day; a separator ends every row
  expect_logged(read_log(table("rtcDate,rtcTime,aX,aY,aZ,gX,gY,gZ,mX,mY,mZ,output_Hz,", [](int k) {
    return fmt::format("05/03/2024,14:22:07.{:02},{},49.876,", k, numbers(k));
  })));
  // ACEINNA: a unit of time
  expect_logged(read_log(table(
                    "timeCntr (msec), xAccel (m/s/s), yAccel (m/s/s), zAccel (m/s/s), "
                    "xRate (deg/s), yRate (deg/s), zRate (deg/s), xMag (G), yMag (G), "
                    "zMag (G)",
                    [](int k) { return fmt::format("{}, {}", 66500 + 10 * k, numbers(k, ", ")); })),
                {1.0, kDeg, 100.0});
  // DatCon: a word that ends with "time"
  expect_logged(
      read_log(table("Clock:offsetTime,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z",
                     [](int k) { return fmt::format("{},{}", 0.01 * k, numbers(k)); })));
  // What falls is none.
  const InputError error = test::error_of([] {
    read_log(table("uptime,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z",
                   [](int k) { return fmt::format("{},{}", reading(k, 1), numbers(k)); }));
  });
  EXPECT_THAT(error.problem, HasSubstr("no column t"));
}

TEST(Loggers, put_a_device_before_each_name) {
  // MicroStrain's SensorConnect
  std::string header = "FILE_INFO\nName,inertial\n\nDATA_START\nTime";
  for (const char* sensor : {"scaledAccel", "scaledGyro", "scaledMag"}) {
    for (const char axis : {'X', 'Y', 'Z'}) {
      header += fmt::format(",inertial-6284.48123:{}{}", sensor, axis);
    }
  }
  expect_logged(
      read_log(table(
          header,
          [](int k) { return fmt::format("03/05/2024 14:22:07.{:02}0000000,{}", k, numbers(k)); })),
      {kG, 1.0, 100.0});
}

TEST(Loggers, of_two_devices_in_a_table_the_one_with_all_sensors_is_read) {
  const Recording r =
      read_log(table("time,IMU(0):accelX,IMU(0):accelY,IMU(0):accelZ,IMU(1):accelX,IMU(1):accelY,"
                     "IMU(1):accelZ,IMU(1):gyroX,IMU(1):gyroY,IMU(1):gyroZ,IMU(1):magX,IMU(1):magY,"
                     "IMU(1):magZ",
                     [](int k) { return fmt::format("{},7,8,9,{}", 0.01 * k, numbers(k)); }));
  expect_logged(r);
  EXPECT_THAT(r.notes, Contains(HasSubstr("--map 'acc_x=IMU(0):accelX'")));
}

TEST(Loggers, name_a_sensor_above_the_first_of_its_columns) {
  expect_logged(read_log(table("t,Accelerometer [m/s2],,,Gyroscope [rad/s],,,Magnetometer [µT],,",
                               [](int k) { return fmt::format("{},{}", 0.01 * k, numbers(k)); })));
  // GoPro's telemetry, whose clock in milliseconds has a name of its own
  test::TempFolder folder;
  for (const auto& [file, name, first] : {std::tuple("X-ACCL.csv", "Accelerometer [m/s2]", 0),
                                          {"X-GYRO.csv", "Gyroscope [rad/s]", 3},
                                          {"X-MAGN.csv", "Magnetometer [µT]", 6}}) {
    const std::string header =
        fmt::format("\"cts\",\"date\",\"{}\",\"1\",\"2\",\"temperature [°C]\"", name);
    folder.write(file, table(header, [first = first](int k) {
                   return fmt::format("{},\"2024-03-05T14:22:07.{:02}0Z\",{},38.5", 10.0 * k, k,
                                      numbers(k, ",", first, 3));
                 }));
  }
  expect_logged(read_recording(folder.path("")));
}

TEST(Loggers, name_each_column_by_sensor_axis_and_number_and_put_a_time_before_it) {
  // Delsys
  std::string header;
  for (const char* channel :
       {"ACC.X 1 [G]", "ACC.Y 1 [G]", "ACC.Z 1 [G]", "GYRO.X 1 [deg/sec]", "GYRO.Y 1 [deg/sec]",
        "GYRO.Z 1 [deg/sec]", "MAG.X 1 [uT]", "MAG.Y 1 [uT]", "MAG.Z 1 [uT]"}) {
    header += fmt::format("{}X[s],\"Avanti Sensor 1: {}\"", header.empty() ? "" : ",", channel);
  }
  const std::string content = table(header, [](int k) {
    std::string row;
    for (int c = 0; c < 9; ++c) {
      row += fmt::format("{}{},{}", c == 0 ? "" : ",", 0.01 * k, reading(k, c));
    }
    return row;
  });
  expect_logged(read_log(content), {kG, kDeg, 1.0});
}

TEST(Loggers, write_one_axis_a_row_with_its_unit) {
  // Tinkerforge: a decimal comma in the time, units of a sixteenth
  const std::string content = table("TIME;NAME;UID;VAR;RAW;UNIT", [](int k) {
    std::string rows;
    for (int c = 0; c < 9; ++c) {
      static const char* const kNames[] = {"Acceleration", "Angular Velocity", "Magnetic Field"};
      static const char* const kUnits[] = {"cm/s²", "1/16 °/s", "1/16 µT"};
      rows += fmt::format("{}05.03.2024 14:22:07,{:02}0;IMU Brick 2.0;6xKBxE;{}-{};{};{}",
                          c == 0 ? "" : "\n", k, kNames[c / 3], "XYZ"[c % 3], reading(k, c),
                          kUnits[c / 3]);
    }
    return rows;
  });
  expect_logged(read_log(content), {0.01, kDeg / 16, 1.0 / 16});
}

TEST(Loggers, number_their_sensors_as_android_does) {
  const std::string content = table("timestamp,sensorType,accuracy,x,y,z", [](int k) {
    const long long ns = 52331000000000LL + 10000000LL * k;
    return fmt::format("{0},1,3,{1}\n{0},9,3,0,0,9.8\n{0},4,3,{2}\n{0},2,3,{3}", ns,
                       numbers(k, ",", 0, 3), numbers(k, ",", 3, 3), numbers(k, ",", 6, 3));
  });
  expect_logged(read_log(content));
}

TEST(Loggers, begin_their_lines_with_the_mark_of_a_comment) {
  // Razor
  std::string content;
  for (int k = 0; k < kLoggedRows; ++k) {
    content += fmt::format("#A-C={}\n#M-C={}\n#G-C={}\n", numbers(k, ",", 0, 3),
                           numbers(k, ",", 6, 3), numbers(k, ",", 3, 3));
  }
  CsvOptions options;
  options.rate_hz = 100.0;
  expect_logged(read_log(content, options));
}

TEST(Loggers, write_accelerations_in_parts_and_with_apples_sign) {
  const auto rows = [](int k) {
    std::string row = fmt::format("{}", 0.01 * k);
    for (int axis = 0; axis < 3; ++axis) row += fmt::format(",{}", reading(k, axis) - 0.25);
    return row + ",0.25,0.25,0.25," + numbers(k, ",", 3, 6);
  };
  const std::string rest = ",gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z";
  const Recording apple = read_log(
      table("timestamp,gravity.x,gravity.y,gravity.z,userAcceleration.x,userAcceleration.y,"
            "userAcceleration.z" +
                rest,
            rows));
  expect_logged(apple, {-1.0, 1.0, 1.0});
  EXPECT_THAT(apple.notes, Contains(HasSubstr("the sum of gravity and")));
  const Recording in_g = read_log(
      table("timestamp,motionGravityX(G),motionGravityY(G),motionGravityZ(G),"
            "motionUserAccelerationX(G),motionUserAccelerationY(G),motionUserAccelerationZ(G)" +
                rest,
            rows));
  expect_logged(in_g, {-kG, 1.0, 1.0});
  expect_logged(
      read_log(table("timestamp,gravity_x,gravity_y,gravity_z,linear_acceleration_x,"
                     "linear_acceleration_y,linear_acceleration_z" +
                         rest,
                     rows)));
  // SensorLog
  expect_logged(
      read_log(
          table("loggingTime(txt),accelerometerAccelerationX(G),accelerometerAccelerationY(G),"
                "accelerometerAccelerationZ(G)" +
                    rest,
                [](int k) { return fmt::format("2024-03-05 14:22:07.{:02},{}", k, numbers(k)); })),
      {-kG, 1.0, 1.0});
}

TEST(Loggers, end_their_header_with_a_column_that_has_nothing) {
  // LabVIEW
  expect_logged(
      read_log(table("LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\n"
                     "***End_of_Header***\t\nSamples\t100\t100\t100\t100\t100\t100\t100\t100\t"
                     "100\nX_Dimension\tTime\tTime\nX0\t0\t0\t0\t0\t0\t0\t0\t0\t0\n"
                     "Delta_X\t1\t1\t1\t1\t1\t1\t1\t1\t1\n"
                     "***End_of_Header***\nX_Value\tacc_x\tacc_y\tacc_z\tgyr_x\tgyr_y\t"
                     "gyr_z\tmag_x\tmag_y\tmag_z\tComment",
                     [](int k) { return fmt::format("{}\t{}", 0.01 * k, numbers(k, "\t")); })));
}

TEST(Loggers, write_chinese_in_the_characters_of_their_system) {
  std::string header =
      "时间\t设备名称\t加速度X(g)\t加速度Y(g)\t加速度Z(g)\t角速度X(°/s)\t角速度Y(°/s)\t"
      "角速度Z(°/s)\t磁场X(uT)\t磁场Y(uT)\t磁场Z(uT)";
  const iconv_t conversion = ::iconv_open("GB18030", "UTF-8");
  if (conversion == reinterpret_cast<iconv_t>(-1)) GTEST_SKIP() << "iconv knows no GB18030";
  std::string gbk(4 * header.size(), '\0');
  char *in = header.data(), *out = gbk.data();
  std::size_t left = header.size(), room = gbk.size();
  ASSERT_NE(::iconv(conversion, &in, &left, &out, &room), static_cast<std::size_t>(-1));
  ::iconv_close(conversion);
  gbk.resize(gbk.size() - room);
  const Recording r = read_log(table(
      gbk, [](int k) { return fmt::format("14:22:07.{:02}\tWT901\t{}", k, numbers(k, "\t")); }));
  expect_logged(r, {kG, kDeg, 1.0});
  EXPECT_THAT(r.notes, Contains(HasSubstr("GB18030")));
}

TEST(LoggersOfFolders, take_the_accelerometer_of_the_gyroscopes_file) {
  // SBG writes accelerations beside the magnetometer's readings, too.
  test::TempFolder folder;
  folder.write("imuData.txt", table("time,accelX,accelY,accelZ,gyroX,gyroY,gyroZ", [](int k) {
                 return fmt::format("{},{}", 0.01 * k, numbers(k, ",", 0, 6));
               }));
  folder.write("mag.txt", table("time,magX,magY,magZ,accelX,accelY,accelZ", [](int k) {
                 return fmt::format("{},{},7,8,9", 0.01 * k, numbers(k, ",", 6, 3));
               }));
  const Recording r = read_recording(folder.path(""));
  expect_logged(r);
  EXPECT_THAT(r.notes, Contains("not used: acc of mag.txt"));
}

TEST(LoggersOfFolders, have_files_of_four_columns_without_a_header) {
  // ADVIO, RoNIN; the clock may stand anywhere
  test::TempFolder folder;
  const auto file = [](int first, bool time_last) {
    std::string text = "# Created at Tue Mar 05\n";
    for (int k = 0; k < kLoggedRows; ++k) {
      const std::string t = fmt::format("{}", 52331000000000LL + 10000000LL * k);
      text += time_last ? fmt::format("{} {}\n", numbers(k, " ", first, 3), t)
                        : fmt::format("{} {}\n", t, numbers(k, " ", first, 3));
    }
    return text;
  };
  const std::string acc = folder.write("acce.txt", file(0, false)),
                    gyr = folder.write("gyro.txt", file(3, true)),
                    mag = folder.write("magnet.txt", file(6, false));
  const Recording r = read_recording(folder.path(""));
  expect_logged(r);
  EXPECT_THAT(r.notes, Contains(HasSubstr("column 4, which never falls, is the time")));
  const std::vector<Recording> given = read_recordings({acc, gyr, mag});
  ASSERT_EQ(given.size(), 1U);
  expect_logged(given.front());
}

TEST(Json, names_and_units_of_columns_beside_arrays_of_numbers) {
  // Edge Impulse
  std::string text = R"({"protected": {"ver": "v1"}, "payload": {"device_type": "NICLA",
      "interval_ms": 10, "sensors": [)";
  const char* const sensors[] = {"acc", "gyr", "mag"};
  for (int c = 0; c < 9; ++c) {
    text += fmt::format(R"({}{{"name": "{}{}", "units": "{}"}})", c == 0 ? "" : ", ",
                        sensors[c / 3], "XYZ"[c % 3],
                        c < 3   ? "m/s2"
                        : c < 6 ? "dps"
                                : "uT");
  }
  text += "], \"values\": [";
  for (int k = 0; k < kLoggedRows; ++k) text += (k == 0 ? "[" : ", [") + numbers(k) + "]";
  text += "]}}";
  test::TempFolder folder;
  expect_logged(read_recording(folder.write("sample.json", text)), {1.0, kDeg, 1.0});
}

TEST(Units, may_have_a_factor) {
  EXPECT_NEAR(unit_in_ours("gyr", "1/16 deg/s").value_or(0.0), kDeg / 16, 1e-15);
  EXPECT_NEAR(unit_in_ours("mag", "0.1 uT").value_or(0.0), 0.1, 1e-15);
  EXPECT_NEAR(unit_in_ours("acc", "0.038").value_or(0.0), 0.038, 1e-15);
  for (const char* text : {"1/16", "1/0 uT", "1/", "0.1 0.1 uT", "0.1 m", "-1 uT", "1e999 uT"}) {
    EXPECT_EQ(unit_in_ours("mag", text).has_value(), std::string(text) == "1/16") << text;
  }
}

}  // namespace
}  // namespace magimu
