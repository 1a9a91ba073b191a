// SPDX-License-Identifier: BSD-3-Clause
// JSON with an object a reading (Sensor Logger), sensors one after the other, and JSON with arrays
// of several devices.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>

#include "recording/read.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr int kReadings = 2000;

std::string readings_of(const std::string& sensor, int x) {
  std::string text;
  for (int k = 0; k < kReadings; ++k) {
    text += fmt::format(
        R"(, {{"sensor": "{}", "time": "{}", "seconds_elapsed": "{:.2f}", "z": "3", "y": "{}", )"
        R"("x": "{}"}})",
        sensor, 1682942400000000000LL + 10'000'000LL * k, 0.01 * k, 0.01 * (k % 50), x);
  }
  return text;
}

TEST(JsonRows, of_sensor_logger_come_one_sensor_after_the_other) {
  const std::string metadata =
      R"({"version": "3", "device name": "Phone 6", "platform": "x", "sensor": "Metadata"})";
  const std::string sensors = readings_of("Accelerometer", 0) + readings_of("Gravity", 0) +
                              readings_of("TotalAcceleration", 1) + readings_of("Gyroscope", 2) +
                              readings_of("Magnetometer", 0) +
                              readings_of("MagnetometerUncalibrated", 3);
  const test::TempFolder folder;
  for (const std::string& text :
       {"[" + metadata + sensors + "]", "[" + sensors.substr(2) + ", " + metadata + "]"}) {
    const Recording r = read_recording(folder.write("log.json", text));
    ASSERT_EQ(r.acc.size(), std::size_t(kReadings));
    ASSERT_EQ(r.gyr.size(), std::size_t(kReadings));
    ASSERT_EQ(r.mag.at(0).size(), std::size_t(kReadings));
    EXPECT_EQ(r.acc.v[7], Vector3(1.0, 0.07, 3.0));
    EXPECT_EQ(r.gyr.v[7], Vector3(2.0, 0.07, 3.0));
    EXPECT_EQ(r.mag[0].v[7], Vector3(3.0, 0.07, 3.0));
    EXPECT_NEAR(r.mag[0].t.back() - r.mag[0].t.front(), 0.01 * (kReadings - 1), 1e-9);
  }
}

// Arrays of one device: each vector is (x, k, 1).
std::string device(const std::string& name, int x, const std::string& sensors) {
  std::string text = fmt::format(R"("{}": {{"Time": [)", name);
  for (int k = 0; k < 50; ++k) text += fmt::format("{}{}", k > 0 ? "," : "", 0.01 * k);
  for (const char sensor : sensors) {
    const char* const word = sensor == 'a' ? "acc" : sensor == 'g' ? "gyr" : "mag";
    text += fmt::format(R"(], "{}": [)", word);
    for (int k = 0; k < 50; ++k) text += fmt::format("{}[{},{},1]", k > 0 ? "," : "", x, k);
  }
  return text + "]}";
}

TEST(JsonArrays, of_two_devices_are_read_of_the_one_with_all_sensors) {
  const test::TempFolder folder;
  const std::string path =
      folder.write("log.json", "{" + device("A", 1, "ag") + "," + device("B", 2, "agm") + "}");
  const Recording r = read_recording(path);
  EXPECT_EQ(r.acc.v[3], Vector3(2, 3, 1));
  EXPECT_EQ(r.gyr.v[3], Vector3(2, 3, 1));
  EXPECT_EQ(r.mag.at(0).v[3], Vector3(2, 3, 1));
  EXPECT_THAT(r.notes, Contains(HasSubstr("--map acc=A.acc --map gyr=A.gyr")));
}

// Several samples under one time (Movesense), in the forms in which its programs write them.
namespace blocks {

constexpr int kBlocks = 50, kOfBlock = 4;

std::string vectors(int block, double plus) {
  std::string out;
  for (int i = 0; i < kOfBlock; ++i) {
    const int k = kOfBlock * block + i;
    out += fmt::format(R"({}{{"x":{},"y":{},"z":9}})", i > 0 ? "," : "", k + plus, 0.1 * (k % 7));
  }
  return "[" + out + "]";
}
std::string sensor(const std::string& name, int block, double plus) {
  return fmt::format(R"("Array{}":{})", name, vectors(block, plus));
}
std::string time(int block) { return fmt::format(R"("Timestamp":{})", 5035 + 80 * block); }
std::string all_sensors(int block) {
  return fmt::format("{{{},{},{},{}}}", time(block), sensor("Acc", block, 0.0),
                     sensor("Gyro", block, 0.25), sensor("Magn", block, 0.5));
}
template <class Text>
std::string for_each_block(const std::string& between, const Text& text) {
  std::string out;
  for (int block = 0; block < kBlocks; ++block) out += (block > 0 ? between : "") + text(block);
  return out;
}

void expect_samples(const Recording& r) {
  ASSERT_EQ(r.acc.size(), std::size_t(kBlocks * kOfBlock));
  ASSERT_EQ(r.gyr.size(), r.acc.size());
  ASSERT_EQ(r.mag.at(0).size(), r.acc.size());
  for (std::size_t k = 0; k < r.acc.size(); ++k) {
    EXPECT_NEAR(r.acc.t[k] - r.acc.t[0], 0.02 * double(k), 1e-9);
    EXPECT_NEAR(r.mag[0].t[k], r.acc.t[k], 1e-9);
    EXPECT_EQ(r.acc.v[k][0], double(k));
    EXPECT_EQ(r.gyr.v[k][0], double(k) + 0.25);
    EXPECT_EQ(r.mag[0].v[k][0], double(k) + 0.5);
  }
  EXPECT_THAT(r.notes, Contains(HasSubstr("several samples a row")));
}

TEST(JsonBlocks, of_all_sensors_in_an_array) {
  const test::TempFolder folder;
  const std::string rows = for_each_block(",\n", all_sensors);
  expect_samples(read_recording(folder.write("a.json", R"({"Meas":{"IMU9":[)" + rows + "]}}")));
  expect_samples(
      read_recording(folder.write("b.json", R"({"data":[)" + for_each_block(",", [](int block) {
                                              return R"({"imu9":)" + all_sensors(block) + "}";
                                            }) + "]}")));
}

TEST(JsonBlocks, of_a_sensor_each) {
  const test::TempFolder folder;
  const auto array = [](const std::string& name, double plus) {
    return "[" +
           for_each_block(",",
                          [&](int block) {
                            return fmt::format("{{{},{}}}", time(block), sensor(name, block, plus));
                          }) +
           "]";
  };
  expect_samples(read_recording(folder.write(
      "a.json", fmt::format(R"({{"Meas":{{"Acc":{},"Gyro":{},"Magn":{}}}}})", array("Acc", 0.0),
                            array("Gyro", 0.25), array("Magn", 0.5)))));
}

TEST(JsonBlocks, in_lines_of_an_object_each) {
  const test::TempFolder folder;
  const std::string lines = for_each_block("\n", [](int block) {
    return fmt::format(R"({{"Body":{},"Uri":"1234/Meas/IMU9/52","Method":"PUT"}})",
                       all_sensors(block));
  });
  expect_samples(read_recording(folder.write("a.json", lines + "\n")));
}

TEST(JsonBlocks, of_magnetometers_alone_are_an_array_of_them) {
  const test::TempFolder folder;
  std::string rows;
  for (int k = 0; k < 50; ++k) {
    rows +=
        fmt::format(R"({}{{"t":{:.2f},"acc":{{"x":{},"y":0,"z":9}},"gyr":{{"x":0,"y":{},"z":0}},)"
                    R"("mag1":{{"x":1,"y":{},"z":3}},"mag2":{{"x":4,"y":{},"z":6}}}})",
                    k > 0 ? "," : "", 0.02 * k, k, k, k, k);
  }
  const Recording r = read_recording(folder.write("a.json", "[" + rows + "]"));
  EXPECT_EQ(r.mag.size(), 2U);
  EXPECT_EQ(r.acc.size(), 50U);
}

}  // namespace blocks

}  // namespace
}  // namespace magimu
