// SPDX-License-Identifier: BSD-3-Clause
// ULog and DataFlash messages byte by byte, with the numbers that their specifications give the
// bytes: here by hand, in real logs by their offsets in the files.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "recording/read.h"
#include "tests/recording/log_writers.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

// "3F 00" -> its bytes; '|' and line ends are for the reader's eye.
std::string from_hex(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i + 1 < text.size();) {
    if (std::isxdigit(static_cast<unsigned char>(text[i])) == 0) {
      ++i;
      continue;
    }
    out += static_cast<char>(std::strtol(text.substr(i, 2).c_str(), nullptr, 16));
    i += 2;
  }
  return out;
}

void expect_sample(const VectorSeries& series, std::size_t k, double t, const Vector3& v) {
  SCOPED_TRACE(fmt::format("sample {}", k));
  ASSERT_LT(k, series.size());
  EXPECT_NEAR(series.t[k], t, 1e-9);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(series.v[k][i], v[i], 1e-9) << i;
}

TEST(LogsByHand, five_messages_of_a_ulog) {
  const std::string head =
      from_hex("55 4C 6F 67 01 12 35 01 00 00 00 00 00 00 00 00") +
      test::ulog_message('B', std::string(40, '\0')) +
      test::ulog_message('F',
                         "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t "
                         "gyro_integral_dt;int32_t accelerometer_timestamp_relative;float[3] "
                         "accelerometer_m_s2;uint32_t accelerometer_integral_dt;") +
      test::ulog_message('F',
                         "vehicle_magnetometer:uint64_t timestamp;uint64_t timestamp_sample;"
                         "uint32_t device_id;float[3] magnetometer_ga;uint8_t calibration_count;"
                         "uint8_t[3] _padding0;") +
      from_hex("12 00 41 | 00 | 00 00 | 73 65 6E 73 6F 72 5F 63 6F 6D 62 69 6E 65 64") +
      test::ulog_message('A', std::string("\0\1\0", 3) + "vehicle_magnetometer");
  const std::string data = from_hex(
      // size, 'D', number | 1 s | 0.5 -0.25 0.125 | 5000 us | 0 us | 1.5 -2 9.75 | 5000 us
      "2E 00 44 00 00 | 40 42 0F 00 00 00 00 00 | 00 00 00 3F 00 00 80 BE 00 00 00 3E |"
      "88 13 00 00 | 00 00 00 00 | 00 00 C0 3F 00 00 00 C0 00 00 1C 41 | 88 13 00 00"
      // 1.003 s, measured at 1.002 s | device 1 | 0.25 -0.5 0.375 gauss | 2; no padding at the end
      "23 00 44 01 00 | F8 4D 0F 00 00 00 00 00 | 10 4A 0F 00 00 00 00 00 | 01 00 00 00 |"
      "00 00 80 3E 00 00 00 BF 00 00 C0 3E | 02"
      // 1.005 s | -0.5 0.75 2 | its accelerometer 500 us before: -1 0 10
      "2E 00 44 00 00 | C8 55 0F 00 00 00 00 00 | 00 00 00 BF 00 00 40 3F 00 00 00 40 |"
      "88 13 00 00 | 0C FE FF FF | 00 00 80 BF 00 00 00 00 00 00 20 41 | 88 13 00 00"
      // 1.010 s | 0 0 0 | no accelerometer (the largest int32_t)
      "2E 00 44 00 00 | 50 69 0F 00 00 00 00 00 | 00 00 00 00 00 00 00 00 00 00 00 00 |"
      "88 13 00 00 | FF FF FF 7F | 00 00 80 BF 00 00 00 00 00 00 20 41 | 88 13 00 00"
      // 1.013 s, measured at 1.012 s | 0.5 0.125 -0.25 gauss
      "23 00 44 01 00 | 08 75 0F 00 00 00 00 00 | 20 71 0F 00 00 00 00 00 | 01 00 00 00 |"
      "00 00 00 3F 00 00 00 3E 00 00 80 BE | 02");
  const test::TempFolder folder;
  const Recording r = read_recording(folder.write("hand.ulg", head + data));
  ASSERT_EQ(r.gyr.size(), 3u);
  expect_sample(r.gyr, 0, 1.0, {0.5, -0.25, 0.125});
  expect_sample(r.gyr, 1, 1.005, {-0.5, 0.75, 2.0});
  expect_sample(r.gyr, 2, 1.010, {0.0, 0.0, 0.0});
  ASSERT_EQ(r.acc.size(), 2u);
  expect_sample(r.acc, 0, 1.0, {1.5, -2.0, 9.75});
  expect_sample(r.acc, 1, 1.0045, {-1.0, 0.0, 10.0});
  ASSERT_EQ(r.mag.at(0).size(), 2u);
  expect_sample(r.mag[0], 0, 1.002, {25.0, -50.0, 37.5});
  expect_sample(r.mag[0], 1, 1.012, {50.0, 12.5, -25.0});
}

// "FMT": a type's number, size, name, letters and names.
std::string flash_format(const std::string& type_and_size, const std::string& name,
                         const std::string& letters, const std::string& names) {
  return from_hex("A3 95 80" + type_and_size) +
         test::Bytes().padded(name, 4).padded(letters, 16).padded(names, 64).text;
}

TEST(LogsByHand, five_messages_of_a_dataflash_log) {
  const std::string head =
      flash_format("80 59", "FMT", "BBnNZ", "Type,Length,Name,Format,Columns") +
      flash_format("40 1F", "PARM", "QNf", "TimeUS,Name,Value") +
      flash_format("90 24", "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ") +
      flash_format("91 23", "MAG", "QBhhhhhhhhhBI",
                   "TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health,S");
  const std::string data = from_hex(
      // 0 s "COMPASS_DIA_X" 2
      "A3 95 40 | 00 00 00 00 00 00 00 00 | 43 4F 4D 50 41 53 53 5F 44 49 41 5F 58 00 00 00 |"
      "00 00 00 40"
      // 1 s, first IMU | 0.5 -0.25 0.125 | 1.5 -2 9.75
      "A3 95 90 | 40 42 0F 00 00 00 00 00 | 00 | 00 00 00 3F 00 00 80 BE 00 00 00 3E |"
      "00 00 C0 3F 00 00 00 C0 00 00 1C 41"
      // 1 s, first compass | 217 4 -586 mG | offsets -97 118 213 | of motors 1 -2 3 | healthy | 0
      "A3 95 91 | 40 42 0F 00 00 00 00 00 | 00 | D9 00 04 00 B6 FD | 9F FF 76 00 D5 00 |"
      "01 00 FE FF 03 00 | 01 | 00 00 00 00"
      // 1.01 s
      "A3 95 90 | 50 69 0F 00 00 00 00 00 | 00 | 00 00 00 BF 00 00 40 3F 00 00 00 40 |"
      "00 00 80 BF 00 00 00 00 00 00 20 41"
      // 1.01 s | -100 256 32 mG | the same offsets, none of motors
      "A3 95 91 | 50 69 0F 00 00 00 00 00 | 00 | 9C FF 00 01 20 00 | 9F FF 76 00 D5 00 |"
      "00 00 00 00 00 00 | 01 | 00 00 00 00");
  const test::TempFolder folder;
  const Recording r = read_recording(folder.write("hand.bin", head + data));
  ASSERT_EQ(r.gyr.size(), 2u);
  expect_sample(r.gyr, 0, 1.0, {0.5, -0.25, 0.125});
  expect_sample(r.gyr, 1, 1.01, {-0.5, 0.75, 2.0});
  ASSERT_EQ(r.acc.size(), 2u);
  expect_sample(r.acc, 0, 1.0, {1.5, -2.0, 9.75});
  expect_sample(r.acc, 1, 1.01, {-1.0, 0.0, 10.0});
  // Logged is DIA (measured + offset) + motors; 10 mG are 1 uT.
  ASSERT_EQ(r.mag.at(0).size(), 2u);
  expect_sample(r.mag[0], 0, 1.0, {20.5, -11.2, -80.2});
  expect_sample(r.mag[0], 1, 1.01, {4.7, 13.8, -18.1});
}

std::string real_log(const char* name) { return std::string(MAGIMU_DATA_DIR) + "/logs/" + name; }

// Bytes 64251, 66653, 67694, 68210, 68821 and 64859, 67046, 67984, 70370, 73668 of the file, taken
// apart by another program (struct.unpack of Python).
TEST(LogsByHand, ten_messages_of_a_real_ulog) {
  const std::string path = real_log("px4_sample_log_small.ulg");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  const Recording r = read_recording(path);
  struct Row {
    double t;
    Vector3 gyr, acc;
  };
  const std::vector<Row> rows = {
      {20.326716,
       {0.002968383487313986, 0.003646239871159196, 0.0009424961172044277},
       {0.0012458056444302201, -0.15434497594833374, -9.63424301147461}},
      {20.488019,
       {0.0015724377008154988, 0.0012462260201573372, 0.002898464212194085},
       {0.011952392756938934, -0.18632270395755768, -9.631083488464355}},
      {20.492907,
       {0.0034213480539619923, 0.0015138390008360147, 0.0010593823390081525},
       {0.040563520044088364, -0.18744470179080963, -9.557543754577637}},
      {20.497795,
       {0.0034603348467499018, 0.003937611822038889, 0.0030161032918840647},
       {0.001878484501503408, -0.17649559676647186, -9.55188274383545}},
      {20.502683,
       {0.00516138318926096, 0.002114824717864394, 0.0036727481056004763},
       {0.039003923535346985, -0.20391887426376343, -9.570425033569336}}};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    expect_sample(r.gyr, k, rows[k].t, rows[k].gyr);
    expect_sample(r.acc, k, rows[k].t, rows[k].acc);
  }
  expect_sample(r.mag[0], 0, 20.310847,
                100.0 * Vector3(0.42917826771736145, -0.11418437212705612, -0.051813360303640366));
  expect_sample(r.mag[0], 1, 20.470848,
                100.0 * Vector3(0.4351249933242798, -0.12016770243644714, -0.060873083770275116));
  expect_sample(r.mag[0], 2, 20.490908,
                100.0 * Vector3(0.43066495656967163, -0.12315934896469116, -0.059363119304180145));
  expect_sample(r.mag[0], 3, 20.510848,
                100.0 * Vector3(0.43066495656967163, -0.11867186427116394, -0.059363119304180145));
  expect_sample(r.mag[0], 4, 20.530849,
                100.0 * Vector3(0.43066495656967163, -0.11867186427116394, -0.059363119304180145));
}

// Bytes 17993, 18607, 18751, 18895, 19049 and 18156, 19356, 20556, 21811, 23001.
TEST(LogsByHand, ten_messages_of_a_real_dataflash_log) {
  const std::string path = real_log("ardupilot_log171.bin");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  const Recording r = read_recording(path);
  struct Row {
    Vector3 gyr, acc, mag_mG;
  };
  const std::vector<Row> rows = {
      {{0.00014373366138897836, -0.00010365076013840735, -0.00015082934987731278},
       {-0.07167863845825195, -0.6270700097084045, -9.587533950805664},
       {217, 4, -586}},
      {{8.288455137517303e-05, 9.151001722784713e-05, -0.0005614803521893919},
       {-0.05932402238249779, -0.6292727589607239, -9.571157455444336},
       {217, 2, -587}},
      {{0.0006284164264798164, 7.352206012001261e-05, -0.0009575507720001042},
       {-0.05732157081365585, -0.6258699297904968, -9.55506706237793},
       {218, 3, -588}},
      {{0.0005851895548403263, 0.0005759523482993245, 0.00042052840581163764},
       {-0.0544564314186573, -0.6353157162666321, -9.547040939331055},
       {218, 3, -586}},
      {{0.0009408540208823979, 9.903308091452345e-05, -0.000254024111200124},
       {-0.08831774443387985, -0.6283393502235413, -9.582648277282715},
       {218, 2, -587}}};
  // The log's parameters COMPASS_DIA, COMPASS_ODI, and the offsets of its messages.
  Matrix3 matrix;
  matrix << 0.9957312941551208, 0.01828811690211296, -0.0027271006256341934,  //
      0.01828811690211296, 1.0081491470336914, -0.0042128413915634155,        //
      -0.0027271006256341934, -0.0042128413915634155, 1.002740502357483;
  const Vector3 offsets(-97, 118, 213);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    SCOPED_TRACE(k);
    expect_sample(r.gyr, k, 11.46 + 0.02 * double(k), rows[k].gyr);
    expect_sample(r.acc, k, 11.46 + 0.02 * double(k), rows[k].acc);
    EXPECT_NEAR(r.mag[0].t[k], 11.477 + 0.1 * double(k), 1e-9);
    const Vector3 logged = matrix * (10.0 * r.mag[0].v[k] + offsets);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(logged[i], rows[k].mag_mG[i], 1e-9);
  }
}

}  // namespace
}  // namespace magimu
