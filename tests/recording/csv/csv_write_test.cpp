// SPDX-License-Identifier: BSD-3-Clause
// What is written reads back bit for bit.
#include <gmock/gmock.h>

#include <bit>
#include <cstdint>
#include <random>

#include "recording/csv/csv.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::ElementsAre;

// Doubles of every size and sign, denormal ones included.
class AnyDouble {
 public:
  double operator()() {
    while (true) {
      const auto value = std::bit_cast<double>(random_());
      if (std::isfinite(value)) return value;
    }
  }
  Vector3 vector() { return {(*this)(), (*this)(), (*this)()}; }

 private:
  std::mt19937_64 random_{42};
};

std::vector<std::uint64_t> bits(const std::vector<double>& values) {
  std::vector<std::uint64_t> all;
  all.reserve(values.size());
  for (const double v : values) all.push_back(std::bit_cast<std::uint64_t>(v));
  return all;
}
std::vector<std::uint64_t> bits(const std::vector<Vector3>& vectors) {
  std::vector<double> values;
  for (const Vector3& v : vectors) values.insert(values.end(), v.begin(), v.end());
  return bits(values);
}
template <class Series>
void expect_identical(const Series& a, const Series& b) {
  EXPECT_EQ(bits(a.t), bits(b.t));
  EXPECT_EQ(bits(a.v), bits(b.v));
}

TEST(WriteCsv, reads_back_as_the_same_doubles_with_every_sensor_at_its_own_times) {
  Recording recording;
  AnyDouble any;
  recording.mag.resize(2);
  recording.mag_names = {"mag1", "mag2"};
  recording.pos.emplace();
  for (int k = 0; k < 2000; ++k) {
    const double t = k / 3.0;
    recording.acc.push_back(t, any.vector());
    recording.gyr.push_back(t + 1e-3, any.vector());
    if (k % 3 == 0) recording.mag[0].push_back(t, any.vector());
    if (k % 7 == 0) recording.mag[1].push_back(t + 0.1, any.vector());
    if (k % 50 == 0) recording.pos->push_back(t, any.vector());
    for (const char* name : {"temp", "current"}) {
      if (k % 100 != 1) continue;
      recording.aux[name].t.push_back(t);
      recording.aux[name].v.push_back(any());
    }
  }
  const test::TempFolder folder;
  write_csv(recording, folder.path("out.csv"));
  const Recording back = read_csv(folder.path("out.csv"));

  expect_identical(back.acc, recording.acc);
  expect_identical(back.gyr, recording.gyr);
  ASSERT_EQ(back.mag.size(), 2u);
  expect_identical(back.mag[0], recording.mag[0]);
  expect_identical(back.mag[1], recording.mag[1]);
  EXPECT_EQ(back.mag_names, recording.mag_names);
  expect_identical(*back.pos, *recording.pos);
  expect_identical(back.aux.at("temp"), recording.aux.at("temp"));
  expect_identical(back.aux.at("current"), recording.aux.at("current"));
}

TEST(WriteCsv, merges_the_sensors_into_one_row_a_time) {
  Recording recording;
  recording.acc.push_back(0.0, {0.5, 0.1, 9.8});
  recording.acc.push_back(0.01, {1, 2, 3});
  recording.gyr = recording.acc;
  recording.mag.emplace_back().push_back(0.01, {20, -1e-7, 1e22});
  recording.mag_names = {"mag"};
  recording.aux["temp"] = {{0.02}, {25.0}};
  EXPECT_EQ(csv_text(recording),
            "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z,temp\n"
            "0,0.5,0.1,9.8,0.5,0.1,9.8,,,,\n"
            "0.01,1,2,3,1,2,3,20,-1e-07,1e+22,\n"
            "0.02,,,,,,,,,,25\n");
}

TEST(WriteCsv, numbers_magnetometers_that_have_no_names) {
  Recording recording;
  recording.mag.resize(2);
  EXPECT_EQ(csv_text(recording),
            "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag1_x,mag1_y,mag1_z,mag2_x,mag2_y,mag2_z\n");
}

TEST(WriteCsv, says_which_file_cannot_be_written) {
  const InputError error = test::error_of([] { write_csv({}, "no/such/folder/out.csv"); });
  EXPECT_EQ(error.file, "no/such/folder/out.csv");
}

}  // namespace
}  // namespace magimu
