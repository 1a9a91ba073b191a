// SPDX-License-Identifier: BSD-3-Clause
// Tables of pandas: columns of several levels, an index with a name and without, .NET's ticks.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdint>

#include "recording/checks/quality.h"
#include "recording/csv/csv.h"
#include "recording/data/units.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

std::string pandas_rows(const std::string& header, int columns = 9) {
  std::string out = header;
  for (int k = 0; k < 100; ++k) {
    out += fmt::format("{:.2f}", 0.02 * k);
    for (int c = 0; c < columns; ++c) out += fmt::format(",{}", c == 2 ? 9.0 : c + 0.01 * (k % 7));
    out += "\n";
  }
  return out;
}

void expect_pandas(const std::string& text) {
  SCOPED_TRACE(text.substr(0, 120));
  const Recording r = csv_recording(text, "frame.csv");
  ASSERT_EQ(r.acc.size(), 100u);
  EXPECT_NEAR(r.gyr.t.back(), 1.98, 1e-12);
  EXPECT_EQ(r.acc.v[1], Vector3(0.01, 1.01, 9.0));
  EXPECT_EQ(r.mag.at(0).v[1], Vector3(6.01, 7.01, 8.01));
}

TEST(CsvPandas, columns_of_two_levels_are_joined) {
  const std::string levels = "acc,acc,acc,gyr,gyr,gyr,mag,mag,mag\n", axes = "x,y,z,x,y,z,x,y,z\n";
  expect_pandas(pandas_rows("sensor," + levels + "axis," + axes + "time,,,,,,,,,\n"));
  expect_pandas(pandas_rows("sensor," + levels + "axis," + axes + "my clock,,,,,,,,,\n"));
  expect_pandas(pandas_rows("sensor," + levels + "axis," + axes));
  expect_pandas(pandas_rows("," + levels + "," + axes));
  expect_pandas(pandas_rows("," + levels + "," + axes + "t,,,,,,,,,\n"));
}

TEST(CsvPandas, columns_of_three_levels_are_joined) {
  expect_pandas(
      pandas_rows("device,imu,imu,imu,imu,imu,imu,imu,imu,imu\n"
                  "sensor,acc,acc,acc,gyr,gyr,gyr,mag,mag,mag\naxis,x,y,z,x,y,z,x,y,z\n"
                  "time,,,,,,,,,\n"));
}

TEST(CsvPandas, a_row_of_units_is_no_level) {
  const Recording r = csv_recording(
      pandas_rows("t,ax,ay,az,gx,gy,gz,mx,my,mz\ns,g,g,g,rad/s,rad/s,rad/s,uT,uT,uT\n"), "u.csv");
  EXPECT_NEAR(r.acc.v[1][2], 9.0 * 9.80665, 1e-9);
}

TEST(CsvPandas, ticks_of_dotnet_and_of_windows_are_dates) {
  for (const std::int64_t start : {638'400'000'000'000'000, 133'500'000'000'000'000}) {
    std::string text = "Timestamp,ax,ay,az,gx,gy,gz,mx,my,mz\n";
    for (int k = 0; k < 100; ++k) {
      text += fmt::format("{},0.{},0,9,0.1,0.2,0.3,20,0,{}\n", start + 200'000 * k, k, k);
    }
    const Recording r = csv_recording(text, "ticks.csv");
    EXPECT_NEAR(r.acc.t.back(), 1.98, 3e-5);  // a double holds 638 10^15 to 128 ticks
    EXPECT_THAT(r.notes, Contains(HasSubstr("ticks of 100 ns since")));
  }
}

TEST(CsvPandas, ticks_of_no_date_are_asked_for) {
  std::string text = "ticks,ax,ay,az,gx,gy,gz,mx,my,mz\n";
  for (int k = 0; k < 100; ++k) {
    text += fmt::format("{},0.{},0,9,0.1,0.2,0.3,20,0,{}\n", 100'000 * k, k, k);
  }
  const InputError error = test::error_of([&] { csv_recording(text, "ticks.csv"); });
  EXPECT_THAT(error.remedy, HasSubstr("--unit t=1e-7"));
}

TEST(CsvPandas, arbitrary_units_and_counts_need_no_option_to_be_read) {
  const Recording r = csv_recording(
      pandas_rows("t,Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g),Gyroscope X "
                  "(deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Magnetometer X (a.u.),"
                  "Magnetometer Y (a.u.),Magnetometer Z (a.u.)\n"),
      "ximu3.csv");
  EXPECT_NEAR(r.mag.at(0).v[1][0], 6.01 * kArbitraryField, 1e-9);
  EXPECT_THAT(r.cautions, Contains(HasSubstr("arbitrary units")));
  const Recording counts = csv_recording(
      pandas_rows("t,ax [LSB],ay [LSB],az [LSB],gx [raw],gy [raw],gz [raw],mx (counts),my "
                  "(counts),mz (counts)\n"),
      "counts.csv");
  EXPECT_EQ(counts.mag.at(0).v[1], Vector3(6.01, 7.01, 8.01));
}

}  // namespace
}  // namespace magimu
