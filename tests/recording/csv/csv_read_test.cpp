// SPDX-License-Identifier: BSD-3-Clause
// What read_csv understands.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/csv.h"
#include "recording/csv/csv_parser.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kHeader = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
const std::string kRow = "0,1,2,3,4,5,6,7,8,9\n";

Recording read(const std::string& content, const CsvOptions& options = {}) {
  const test::TempFolder folder;
  return read_csv(folder.write("walk.csv", content), options);
}

void expect_row(const Recording& recording) {
  EXPECT_THAT(recording.acc.t, ElementsAre(0.0));
  EXPECT_THAT(recording.acc.v, ElementsAre(Vector3(1, 2, 3)));
  EXPECT_THAT(recording.gyr.v, ElementsAre(Vector3(4, 5, 6)));
  ASSERT_EQ(recording.mag.size(), 1u);
  EXPECT_THAT(recording.mag[0].v, ElementsAre(Vector3(7, 8, 9)));
}

TEST(ReadCsv, every_sensor_gets_its_samples_with_their_times) {
  const Recording recording = read(kHeader + kRow + "0.01,-1,-2,-3,-4,-5,-6,-7,-8,-9\n");
  EXPECT_EQ(recording.name, "walk.csv");
  EXPECT_THAT(recording.acc.t, ElementsAre(0.0, 0.01));
  EXPECT_THAT(recording.acc.v, ElementsAre(Vector3(1, 2, 3), Vector3(-1, -2, -3)));
  EXPECT_THAT(recording.gyr.t, ElementsAre(0.0, 0.01));
  EXPECT_THAT(recording.gyr.v, ElementsAre(Vector3(4, 5, 6), Vector3(-4, -5, -6)));
  EXPECT_THAT(recording.mag[0].v, ElementsAre(Vector3(7, 8, 9), Vector3(-7, -8, -9)));
  EXPECT_THAT(recording.mag_names, ElementsAre("mag"));
  EXPECT_THAT(recording.notes, IsEmpty());
  EXPECT_FALSE(recording.pos.has_value());
  EXPECT_FALSE(recording.truth.has_value());
}

TEST(ReadCsv, columns_come_in_any_order) {
  expect_row(
      read("mag_z,gyr_x,t,acc_z,acc_y,gyr_z,mag_x,acc_x,mag_y,gyr_y\n9,4,0,3,2,6,7,1,8,5\n"));
}

TEST(ReadCsv, an_empty_field_means_no_sample_of_that_sensor) {
  const Recording recording = read(kHeader +
                                   "0,1,2,3,4,5,6,7,8,9\n"
                                   "1,1,2,3,4,5,6,,,\n"
                                   "1.5,,,,,,,7,8,9\n"
                                   "2,1,2,3, ,\t,, , , \n");
  EXPECT_THAT(recording.acc.t, ElementsAre(0, 1, 2));
  EXPECT_THAT(recording.gyr.t, ElementsAre(0, 1));
  EXPECT_THAT(recording.mag[0].t, ElementsAre(0, 1.5));
}

TEST(ReadCsv, an_array_of_magnetometers_comes_in_the_order_of_its_numbers) {
  const Recording recording = read(
      "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,"
      "mag10_x,mag10_y,mag10_z,mag2_x,mag2_y,mag2_z,mag1_x,mag1_y,mag1_z\n"
      "0,1,2,3,4,5,6,10,10,10,2,2,2,1,1,1\n");
  EXPECT_THAT(recording.mag_names, ElementsAre("mag1", "mag2", "mag10"));
  ASSERT_EQ(recording.mag.size(), 3u);
  EXPECT_EQ(recording.mag[0].v[0], Vector3(1, 1, 1));
  EXPECT_EQ(recording.mag[1].v[0], Vector3(2, 2, 2));
  EXPECT_EQ(recording.mag[2].v[0], Vector3(10, 10, 10));
}

TEST(ReadCsv, a_magnetometer_of_an_array_without_samples_is_left_out_and_a_caution_says_so) {
  const Recording recording = read(
      "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag1_x,mag1_y,mag1_z,mag2_x,mag2_y,mag2_z\n"
      "0,1,2,3,4,5,6,,,,7,8,9\n");
  EXPECT_THAT(recording.mag_names, ElementsAre("mag2"));
  EXPECT_EQ(recording.mag[0].v[0], Vector3(7, 8, 9));
  EXPECT_THAT(recording.cautions, ElementsAre(HasSubstr("mag1 is left out: it has no samples")));
}

TEST(ReadCsv, temperature_current_and_position_are_kept_where_they_have_samples) {
  const Recording recording = read(
      "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z,temp,current,pos_x,pos_y,pos_z\n"
      "0,1,2,3,4,5,6,7,8,9,20.5,,0.1,0.2,0.3\n"
      "1,1,2,3,4,5,6,7,8,9,,1.5,,,\n");
  EXPECT_THAT(recording.aux.at("temp").t, ElementsAre(0));
  EXPECT_THAT(recording.aux.at("temp").v, ElementsAre(20.5));
  EXPECT_THAT(recording.aux.at("current").t, ElementsAre(1));
  EXPECT_THAT(recording.aux.at("current").v, ElementsAre(1.5));
  EXPECT_THAT(recording.pos->t, ElementsAre(0));
  EXPECT_EQ(recording.pos->v[0], Vector3(0.1, 0.2, 0.3));
}

TEST(ReadCsv, windows_line_ends_byte_order_mark_comments_spaces_and_blank_lines_do_no_harm) {
  expect_row(
      read("\xEF\xBB\xBF# from my logger\r\n"
           "t, acc_x ,acc_y,acc_z,gyr_x,gyr_y,gyr_z,\"mag_x\",mag_y,mag_z\r\n"
           "\r\n"
           "  # another comment\r\n"
           " 0 ,\t1,+2,3.0,4,5,6e0,7,8,+9 \r\n"
           "\r\n \r\n"));
}

TEST(ReadCsv, the_last_line_needs_no_line_end) {
  expect_row(read(kHeader + kRow.substr(0, kRow.size() - 1)));
}

TEST(ReadCsv, semicolons_or_tabs_may_separate_the_fields) {
  for (const char separator : {';', '\t'}) {
    std::string content = kHeader + kRow;
    std::ranges::replace(content, ',', separator);
    expect_row(read(content));
  }
}

TEST(ReadCsv, unknown_columns_are_ignored_and_named_in_the_notes) {
  const Recording recording = read(
      "battery,t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,"
      "mag_z,label\nfull,0,1,2,3,4,5,6,7,8,9,walking\n");
  expect_row(recording);
  EXPECT_THAT(recording.notes, ElementsAre("columns ignored: \"battery\", \"label\""));
}

TEST(ReadCsv, well_known_names_are_understood_and_the_mapping_is_noted) {
  for (const std::string header :
       {"time,ax,ay,az,gx,gy,gz,mx,my,mz",
        "timestamp,ACC_X,ACC_Y,ACC_Z,gyro_x,gyro_y,gyro_z,mag.x,"
        "mag.y,mag.z",
        "Time,accX,accY,accZ,Gyroscope X,Gyroscope Y,Gyroscope Z,MagX,MagY,MagZ",
        "t,accel_x,accel_y,accel_z,wx,wy,wz,magnetometer_x,magnetometer_y,magnetometer_z"}) {
    SCOPED_TRACE(header);
    const Recording recording = read(fmt::format("{}\n{}", header, kRow));
    expect_row(recording);
    ASSERT_EQ(recording.notes.size(), 1u);
    EXPECT_THAT(recording.notes[0], HasSubstr("as acc_x"));
    EXPECT_THAT(recording.notes[0], HasSubstr("as gyr_z"));
  }
}

TEST(ReadCsv, our_own_name_wins_over_an_alias_of_the_same_quantity) {
  const Recording recording = read("timestamp," + kHeader + "77," + kRow);
  expect_row(recording);
  EXPECT_THAT(recording.notes, ElementsAre("columns ignored: \"timestamp\""));
}

TEST(ReadCsv, options_map_any_header_and_win_over_our_own_names) {
  CsvOptions options;
  options.columns = {{"epoch", "t"}, {"B1", "mag_x"}, {"B2", "mag_y"}, {"B3", "mag_z"}};
  const Recording recording =
      read("epoch,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,B1,B2,B3,mag_x\n0,1,2,3,4,5,6,7,8,9,70\n",
           options);
  expect_row(recording);
  EXPECT_THAT(recording.notes[0], HasSubstr("\"B1\" as mag_x"));
}

TEST(ReadCsv, options_give_the_units_of_the_file) {
  CsvOptions options;
  options.time_unit = 1e-3;
  options.acc_unit = 9.80665;
  options.gyr_unit = 0.5;
  options.mag_unit = 100.0;
  const Recording recording = read(kHeader + "2000,0,0,1,1,2,3,0.25,0,-0.5\n", options);
  EXPECT_EQ(recording.acc.t[0], 2.0);
  EXPECT_EQ(recording.acc.v[0], Vector3(0, 0, 9.80665));
  EXPECT_EQ(recording.gyr.v[0], Vector3(0.5, 1, 1.5));
  EXPECT_EQ(recording.mag[0].v[0], Vector3(25, 0, -50));
}

TEST(ReadCsv, a_time_that_looks_like_milliseconds_is_read_as_such_and_noted) {
  const Recording recording = read(kHeader + kRow + "10,1,2,3,4,5,6,7,8,9\n");
  EXPECT_THAT(recording.acc.t, ElementsAre(0.0, 0.01));
  EXPECT_THAT(recording.notes, ElementsAre(HasSubstr("column \"t\" is read as ms")));
}

TEST(ReadCsv, a_rate_that_no_imu_has_is_noted_where_the_unit_is_given) {
  CsvOptions options;
  options.time_unit = 1.0;
  const Recording recording = read(kHeader + kRow + "10,1,2,3,4,5,6,7,8,9\n", options);
  EXPECT_THAT(recording.notes, Contains(HasSubstr("every 10 s: is the file's time in s?")));
}

TEST(ReadCsv, a_file_without_magnetometer_is_read_if_none_is_required) {
  CsvOptions options;
  options.require_mag = false;
  const Recording recording =
      read("t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n0,1,2,3,4,5,6\n", options);
  EXPECT_THAT(recording.mag, IsEmpty());
  EXPECT_EQ(recording.acc.size(), 1u);
}

TEST(ReadCsv, numbers_are_the_nearest_doubles_in_every_notation) {
  const Recording recording =
      read(kHeader + "0,0.1,-.5,5.,1E3,1e-3,+2.5e+1,123456789012345678,-0,4.9e-324\n");
  EXPECT_EQ(recording.acc.v[0], Vector3(0.1, -0.5, 5.0));
  EXPECT_EQ(recording.gyr.v[0], Vector3(1000, 0.001, 25));
  EXPECT_EQ(recording.mag[0].v[0], Vector3(123456789012345678.0, 0, 4.9e-324));
  EXPECT_TRUE(std::signbit(recording.mag[0].v[0][1]));
}

TEST(ReadCsv, every_number_is_the_double_that_the_c_library_reads) {
  std::mt19937_64 bits(7);
  std::vector<std::string> texts{"9007199254740993",
                                 "9007199254740992.0",
                                 "0.1000000000000000055511",
                                 "123456789012345678",
                                 "1234567890123456789",
                                 "00000000000000000001.5",
                                 "-0.000000000000000001",
                                 "5.",
                                 ".5",
                                 "1e22",
                                 "2.2250738585072014e-308"};
  for (int k = 0; k < 20000; ++k) {
    const double value = std::ldexp(double(bits() >> 11), int(bits() % 80) - 90);
    texts.push_back(fmt::format("{}{:.{}f}", k % 2 == 0 ? "" : "-", value, k % 20));
    if (k % 3 == 0) texts.push_back(fmt::format("{}", value));
  }
  std::string content = kHeader;
  for (std::size_t k = 0; k < texts.size(); ++k) {
    content += fmt::format("{}.5,{},2,3,4,5,6,7,8,9\n", k, texts[k]);
  }
  const Recording recording = read(content);
  for (std::size_t k = 0; k < texts.size(); ++k) {
    ASSERT_EQ(recording.acc.v[k][0], std::strtod(texts[k].c_str(), nullptr)) << texts[k];
  }
}

TEST(CsvColumnName, knows_its_own_names_and_aliases_and_no_others) {
  EXPECT_EQ(csv_column_name("mag12_z"), "mag12_z");
  EXPECT_EQ(csv_column_name("Mag_02_Y"), "mag2_y");
  EXPECT_EQ(csv_column_name("TEMPERATURE"), "temp");
  EXPECT_EQ(csv_column_name("px"), "pos_x");
  for (const char* other : {"", "x", "acc", "acc1_x", "mag1", "max", "quality", "mag9999999_x"}) {
    EXPECT_EQ(csv_column_name(other), "") << other;
  }
}

TEST(CsvParser, takes_the_samples_of_a_stream_as_they_arrive) {
  CsvParser parser("stream");
  EXPECT_THAT(parser.take().mag, IsEmpty());
  parser.line("t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z");
  parser.line("0,1,2,3,4,5,6,7,8,9\r\n");
  EXPECT_EQ(parser.take().acc.size(), 1u);
  EXPECT_EQ(parser.take().acc.size(), 0u);
  parser.line("1,1,2,3,4,5,6,,,");
  parser.line("2,1,2,3,4,5,6,7,8,9");
  const Recording recording = parser.take();
  EXPECT_THAT(recording.acc.t, ElementsAre(1, 2));
  EXPECT_THAT(recording.mag.at(0).t, ElementsAre(2));
  EXPECT_THAT(recording.mag_names, ElementsAre("mag"));
}

TEST(CsvParser, goes_on_after_a_bad_line_and_still_wants_increasing_times) {
  CsvParser parser("stream");
  parser.line(kHeader);
  parser.line(kRow);
  EXPECT_THROW(parser.line("1,2,3"), InputError);
  parser.line("1,1,2,3,4,5,6,7,8,9");
  EXPECT_THAT(parser.take().acc.t, ElementsAre(0, 1));
  const InputError error = test::error_of([&] { parser.line("1,1,2,3,4,5,6,7,8,9"); });
  EXPECT_EQ(error.file, "stream");
  EXPECT_EQ(error.line, 5);
}

}  // namespace
}  // namespace magimu
