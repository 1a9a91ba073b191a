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

}  // namespace
}  // namespace magimu
