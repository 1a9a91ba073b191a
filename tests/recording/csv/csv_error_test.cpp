// SPDX-License-Identifier: BSD-3-Clause
// What read_csv refuses: every message names the place, the problem and the remedy.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "recording/csv/csv.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::HasSubstr;

const std::string kColumns = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
const std::string kNumbers = "0,1,2,3,4,5,6,7,8,9\n";

// Reads the content, which must fail at the line and column (0: none), with these words.
void expect_error(const std::string& content, long line, long column, const std::string& problem,
                  const std::string& remedy, const CsvOptions& options = {}) {
  SCOPED_TRACE(content.substr(0, 200));
  const test::TempFolder folder;
  const std::string path = folder.write("bad.csv", content);
  const InputError error = test::error_of([&] { read_csv(path, options); });
  EXPECT_EQ(error.file, path);
  EXPECT_EQ(error.line, line);
  EXPECT_EQ(error.column, column);
  EXPECT_THAT(error.problem, HasSubstr(problem));
  EXPECT_THAT(error.remedy, HasSubstr(remedy));
  EXPECT_THAT(error.what(), HasSubstr(error.problem + "; " + error.remedy));
}

TEST(ReadCsvErrors, a_missing_file_is_named) {
  const InputError error = test::error_of([] { read_csv("no/such/file.csv"); });
  EXPECT_STREQ(error.what(),
               "no/such/file.csv: there is no such file; check the path and its spelling");
}

TEST(ReadCsvErrors, a_folder_is_not_a_recording) {
  const test::TempFolder folder;
  const InputError error = test::error_of([&] { read_csv(folder.path("")); });
  EXPECT_THAT(error.problem, HasSubstr("a folder"));
  EXPECT_THAT(error.remedy, HasSubstr("files in it"));
}

TEST(ReadCsvErrors, an_empty_file_has_nothing_to_read) {
  expect_error("", 0, 0, "the file is empty", "record again");
  expect_error("\n# only a comment\n\n", 0, 0, "the file is empty", "record again");
}

TEST(ReadCsvErrors, a_header_without_data_rows_is_not_a_recording) {
  expect_error(kColumns, 0, 0, "no data rows", "record again");
}

TEST(ReadCsvErrors, numbers_in_the_first_line_mean_that_the_header_is_missing) {
  expect_error(kNumbers + kNumbers, 1, 0, "not the names of the columns",
               "put a header line above");
  expect_error(kNumbers + kNumbers, 1, 0, "10 of them", "--columns t,acc_x");
}

TEST(ReadCsvErrors, a_header_needs_the_time) {
  expect_error("# mine\nacc_x,acc_y,acc_z\n1,2,3\n", 2, 0, "no column t", "name the time column t");
  expect_error("hello world\n", 1, 0, "the columns there are: \"hello world\"", "time column t");
}

TEST(ReadCsvErrors, every_sensor_needs_its_three_axes) {
  expect_error("t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y\n", 1, 8,
               "has mag_x and mag_y but no mag_z", "add the missing column");
  expect_error("t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag3_z\n", 1, 8,
               "has mag3_z but no mag3_x and no mag3_y", "rename mag3_z");
}

TEST(ReadCsvErrors, accelerometer_gyroscope_and_magnetometer_must_be_there) {
  expect_error("t,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n", 1, 0,
               "the columns acc_x, acc_y and acc_z are missing", "map the file");
  expect_error("t,acc_x,acc_y,acc_z,mag_x,mag_y,mag_z\n", 1, 0,
               "the columns gyr_x, gyr_y and gyr_z are missing", "map the file's own names");
  expect_error("t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n", 1, 0,
               "the columns mag_x, mag_y and mag_z are missing", "map the file");
}

TEST(ReadCsvErrors, all_that_is_missing_is_told_at_once_with_one_line_of_options) {
  const std::string head = "t,acc_x,acc_y,acc_z,Spin X [deg/s],Spin Y [deg/s],Spin Z [deg/s]";
  expect_error(head + ",nx,ny,nz\n", 1, 0,
               "the columns gyr_x, gyr_y, gyr_z, mag_x, mag_y and mag_z are missing",
               "--map 'gyr_x=Spin X [deg/s]' --map 'gyr_y=Spin Y [deg/s]' --map 'gyr_z=Spin Z "
               "[deg/s]' --map mag_x=nx --map mag_y=ny --map mag_z=nz");
  expect_error("when,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,q1,q2,q3\n", 1, 0,
               "there is no column t, the time, and the columns mag_x, mag_y and mag_z are missing",
               "--map mag_x=NAME");
}

TEST(ReadCsvErrors, a_few_broken_lines_are_set_aside_and_many_are_an_error) {
  const auto text = [](int broken) {
    std::string out = kColumns;
    for (int k = 0; k < 500; ++k) {
      out += k > 0 && k <= broken ? std::string("0.5,1,2,3.1.4,6\n")
                                  : fmt::format("{},1,2,3,4,5,6,7,8,{}\n", 0.01 * k, k);
    }
    return out;
  };
  const Recording recording = csv_recording(text(4), "rec");
  EXPECT_EQ(recording.acc.size(), 496u);
  EXPECT_THAT(recording.cautions, testing::ElementsAre(testing::HasSubstr(
                                      "lines that cannot be read: 4 of 501, the first in line 3")));
  const InputError error = test::error_of([&] { csv_recording(text(6), "rec"); });
  EXPECT_EQ(error.line, 3);
}

TEST(ReadCsvErrors, a_needed_sensor_must_have_samples) {
  expect_error(kColumns + "0,,,,4,5,6,7,8,9\n", 0, 0, "acc_x, acc_y and acc_z are all empty",
               "check the logger");
  expect_error(kColumns + "0,1,2,3,,,,7,8,9\n", 0, 0, "gyr_x, gyr_y and gyr_z are all empty",
               "check the logger");
  expect_error(kColumns + "0,1,2,3,4,5,6,,,\n", 0, 0, "no magnetometer has a sample",
               "check the logger");
}

TEST(ReadCsvErrors, two_columns_may_not_claim_the_same_quantity) {
  expect_error("t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z,acc_y\n", 1, 11,
               "columns 3 (\"acc_y\") and 11 (\"acc_y\") are both acc_y", "delete or rename");
  expect_error("time,timestamp,acc_x\n", 1, 2, "are both t", "delete or rename one");
}

TEST(ReadCsvErrors, options_must_name_columns_that_are_there_and_quantities_that_exist) {
  CsvOptions options;
  options.columns = {{"B1", "mag_x"}};
  expect_error(kColumns + kNumbers, 1, 0, "no column \"B1\"", "the columns there are: \"t\"",
               options);
  options.columns = {{"mag_x", "magnet"}};
  expect_error(kColumns + kNumbers, 1, 0, "\"magnet\", which is no name of ours", "use t, acc_x",
               options);
}

TEST(ReadCsvErrors, text_in_a_number_is_shown_with_line_field_and_column_name) {
  expect_error(kColumns + kNumbers + "1,1,2,3,4,oops,6,7,8,9\n", 3, 6,
               "\"oops\" in column gyr_y is not a number", "leave the field empty");
  for (const std::string text : {"1.5x", "1 2", "0x10", "--1", "+-1", "-", "+"}) {
    expect_error(kColumns + fmt::format("0,{},2,3,4,5,6,7,8,9\n", text), 2, 2, "is not a number",
                 "-1.25");
  }
}

TEST(ReadCsvErrors, numbers_beyond_double_are_not_finite) {
  for (const std::string text : {"1e400", "-1e400"}) {
    expect_error(kColumns + fmt::format("0,1,2,3,4,5,6,7,8,{}\n", text), 2, 10,
                 "in column mag_z is not a finite number", "leave the field empty");
  }
}

TEST(ReadCsvErrors, a_row_has_as_many_fields_as_the_header) {
  expect_error(kColumns + kNumbers + "1,1,2,3,4,5,6,7,8\n" + kNumbers, 3, 0,
               "this row has 9 fields, the header has 10", "cut off");
  expect_error(kColumns + "0,1,2,3,4,5,6,7,8,9,10\n", 2, 0, "has 11 fields, the header has 10",
               "complete or delete the row");
}

TEST(ReadCsvErrors, times_that_go_back_again_and_again_are_none) {
  std::string rows;
  for (int k = 40; k > 0; --k) rows += fmt::format("{},1,2,3,4,5,6,7,8,9\n", 0.5 * k);
  expect_error(kColumns + rows, 6, 1, "the time (column t) does not increase", "sort the rows");
}

TEST(ReadCsvErrors, every_row_needs_a_time) {
  expect_error(kColumns + ",1,2,3,4,5,6,7,8,9\n", 2, 1, "the time (column t) is empty",
               "give every row a time");
}

TEST(ReadCsvErrors, the_axes_of_a_sensor_are_empty_together_or_not_at_all) {
  expect_error(kColumns + "0,1,2,3,4,5,6,7,,9\n", 2, 9, "column mag_y is empty, but mag_x is not",
               "all three axes");
}

TEST(ReadCsvErrors, binary_content_is_recognized) {
  using std::string_literals::operator""s;
  expect_error("\x7f"s + "ELF\0\0\1\2"s, 1, 0, "binary content", "a ROS bag, MCAP, ULog");
  expect_error(kColumns + kNumbers + "1,2\0,3\n"s, 3, 0, "binary content", "a ROS bag, MCAP, ULog");
}

TEST(ReadCsvErrors, what_a_message_shows_of_the_file_is_short_and_printable) {
  expect_error(kColumns + "0," + std::string(1000, 'x') + ",2,3,4,5,6,7,8,9\n", 2, 2,
               "\"" + std::string(40, 'x') + "...\" in", "");
  expect_error(kColumns + "0,\x1b[31m,2,3,4,5,6,7,8,9\n", 2, 2, "\"?[31m\"", "");
  expect_error(kColumns + "0,\xff\xfe,2,3,4,5,6,7,8,9\n", 2, 2, "\"??\"", "");
  expect_error(kColumns + "0,1\xc2\xb0,2,3,4,5,6,7,8,9\n", 2, 2, "\"1\xc2\xb0\"", "");
}

}  // namespace
}  // namespace magimu
