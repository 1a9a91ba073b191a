// SPDX-License-Identifier: BSD-3-Clause
// What strangers throw at the program: it exits with 1 or 2, names the file or option and the line,
// column or axis, says what to do, prints no half result and leaves no half file.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <sstream>

#include "tests/apps/program.h"

namespace magimu {
namespace {

using test::Outcome;
using testing::AnyOf;
using testing::HasSubstr;
using testing::IsEmpty;

using Row = std::vector<double>;  // t, acc, gyr, mag
using Table = std::vector<Row>;
const std::string kHeader = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";

std::string csv(const Table& table) {
  std::ostringstream out;
  out.precision(12);
  out << kHeader;
  for (const Row& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) out << (i > 0 ? "," : "") << row[i];
    out << "\n";
  }
  return out.str();
}

// A good recording of a minute, as the program simulates it; made once.
const std::string& good_text() {
  static const std::string text = [] {
    const test::Program magimu;
    magimu("simulate -o rec.csv --motion hand --rate 50 --duration 60 --seed 3");
    return magimu.text("rec.csv");
  }();
  return text;
}

const Table& good() {
  static const Table table = [] {
    Table out;
    std::istringstream lines(good_text());
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line)) {
      Row row;
      std::istringstream fields(line);
      for (std::string field; std::getline(fields, field, ',');) row.push_back(std::stod(field));
      out.push_back(row);
    }
    return out;
  }();
  return table;
}

// The good recording with every row changed.
std::string each(const std::function<void(Row&)>& change) {
  Table table = good();
  for (Row& row : table) change(row);
  return csv(table);
}
std::string scaled(std::size_t first, std::size_t count, double factor) {
  return each([=](Row& row) {
    for (std::size_t i = first; i < first + count; ++i) row[i] *= factor;
  });
}
// The good recording with a field's text replaced in one line (2: the first with data), and in more
// at its end than are left out as broken.
std::string with_field(std::size_t line, std::size_t column, const std::string& text) {
  std::istringstream lines(good_text());
  std::string out, one;
  for (std::size_t i = 1; std::getline(lines, one); ++i) {
    if (i == line || (i > 2000 && i % 10 == 0)) {
      std::istringstream fields(one);
      std::string changed;
      std::size_t k = 1;
      for (std::string field; std::getline(fields, field, ','); ++k) {
        changed += (k > 1 ? "," : "") + (k == column ? text : field);
      }
      one = changed;
    }
    out += one + "\n";
  }
  return out;
}

// The first bytes of a BROAD recording; empty where it is absent.
std::string real(const std::string& name, std::size_t bytes) {
  return test::content_of(std::string(MAGIMU_DATA_DIR) + "/broad/" + name).substr(0, bytes);
}

constexpr double kG = 9.80665, kDeg = std::numbers::pi / 180.0;
constexpr const char* kCalibrate = "calibrate rec -o out.json";

struct Bad {
  std::string name;
  std::function<std::string()> content;  // of the file "rec"; empty function: there is none
  std::string says, remedy;
  std::string command = kCalibrate;
};

void PrintTo(const Bad& bad, std::ostream* out) { *out << bad.name; }

class BadInput : public testing::TestWithParam<Bad> {};

TEST_P(BadInput, is_refused_with_place_reason_and_remedy) {
  const Bad& bad = GetParam();
  const test::Program magimu;
  std::filesystem::create_directory(magimu.folder().path("folder"));
  if (bad.content) {
    const std::string content = bad.content();
    if (content.empty() && bad.name.starts_with("truncated")) {
      GTEST_SKIP() << "This case needs the BROAD recordings, which are not part of the project.";
    }
    magimu.folder().write("rec", content);
  }
  const Outcome run = magimu(bad.command);
  EXPECT_THAT(run.exit_code, AnyOf(1, 2)) << run.out << run.err;
  const bool info = bad.command.starts_with("info");  // what it found is its result
  EXPECT_THAT(run.err + (info ? run.out : ""), HasSubstr(bad.says));
  EXPECT_THAT(run.err + (info ? run.out : ""), HasSubstr(bad.remedy));
  EXPECT_THAT(run.err, AnyOf(HasSubstr("rec"), HasSubstr("--"), HasSubstr("/dev/full")))
      << "names no file and no option";
  EXPECT_THAT(run.err, testing::Not(HasSubstr("internal error")));
  if (run.exit_code == 2) {
    EXPECT_THAT(run.out, IsEmpty());
    EXPECT_FALSE(magimu.has("out.json"));
  } else if (magimu.has("out.json")) {
    EXPECT_EQ(magimu.json("out.json")["trust"]["verdict"], "no");
  }
  for (const auto& file : std::filesystem::directory_iterator(magimu.folder().path(""))) {
    EXPECT_THAT(file.path().filename().string(),
                AnyOf(".out", ".err", "rec", "out.json", "folder"));
  }
}

const std::vector<Bad> kNoRecording{
    {"missing_file", {}, "rec: there is no such file", "check the path"},
    {"empty", [] { return std::string("\n"); }, "the file is empty", "record again"},
    {"header_only", [] { return kHeader; }, "no data rows", "record again"},
    {"no_header", [] { return good_text().substr(kHeader.size()); }, "the first line holds numbers",
     "put a header line above"},
    {"missing_column",
     [] { return "t,acc_x,acc_y,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n0,1,2,3,4,5,6,7,8\n"; },
     "has acc_x and acc_y but no acc_z", "add the missing column"},
    {"no_time", [] { return good_text().substr(2); }, "there is no column t", "--map t=NAME"},
    {"no_gyroscope", [] { return "t,acc_x,acc_y,acc_z,mag_x,mag_y,mag_z\n0,1,2,3,4,5,6\n"; },
     "gyr_x, gyr_y and gyr_z are missing", "--map gyr_x=NAME"},
    {"no_magnetometer", [] { return "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n0,1,2,3,4,5,6\n"; },
     "mag_x, mag_y and mag_z are missing", "--map mag_x=NAME"},
    {"one_sensor_of_a_phone",
     [] { return "time,seconds_elapsed,z,y,x\n1718030736872695300,0,1,2,3\n"; },
     "are missing; the columns there are", "--map acc_x=NAME"},
    {"column_twice", [] { return "t,t," + kHeader.substr(2) + "0,0,1,2,3,4,5,6,7,8,9\n"; },
     "are both t", "delete or rename"},
    {"unknown_unit_in_header",
     [] { return "t,acc_x (furlong),acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n"; },
     "rec:1:2: column", "--unit acc=UNIT"},
    {"text_in_a_number", [] { return with_field(1500, 6, "oops"); },
     "rec:1500:6: \"oops\" in column gyr_y", "-1.25e-3"},
    {"decimal_comma", [] { return with_field(17, 3, "\"0,5\""); }, "rec:17:3",
     "write it like -1.25e-3"},
    {"beyond_double", [] { return with_field(9, 2, "1e999"); }, "rec:9:2", "leave the field empty"},
    {"all_nan", [] { return kHeader + "0,nan,nan,nan,nan,nan,nan,nan,nan,nan\n"; },
     "rec: the columns acc_x, acc_y and acc_z are all empty", "check the logger"},
    {"half_a_vector", [] { return with_field(30, 9, ""); }, "rec:30:9: column mag_y is empty",
     "all three axes"},
    {"time_missing", [] { return with_field(30, 1, ""); }, "rec:30:1", "give every row a time"},
    {"time_backwards", [] { return each([](Row& r) { r[0] = -r[0]; }); },
     "the time (column t) does not increase", "where its clock was set back"},
    {"time_twice",
     [] {
       return each([](Row& r) {
         const double k = std::round(50.0 * r[0]);
         r[0] = 0.02 * std::floor(k * k / 6000.0);
       });
     },
     "the time of another row and other readings", "--rate HZ"},
    {"counts_samples", [] { return each([](Row& r) { r[0] = std::round(50.0 * r[0]); }); },
     "counts samples", "--rate HZ"},
    {"time_in_ms_or_us", [] { return each([](Row& r) { r[0] *= 1e4; }); },
     "5 Hz if it is in ms, 5000 Hz if it is in us", "--unit t=ms or --unit t=us"},
    {"short_row",
     [] {
       std::string rows;
       for (int k = 0; k < 60; ++k) rows += "61,1,2\n";
       return good_text() + rows + "62,1,2,3,4,5,6,7,8,9\n";
     },
     "rec:3002: this row has 3 fields", "cut off"},
    {"long_row", [] { return kHeader + "0,1,2,3,4,5,6,7,8,9,10\n"; },
     "rec:2: this row has 11 fields", "delete the row"},
    {"binary",
     [] {
       return std::string(
           "\x7f"
           "ELF\0\1\2\3",
           8);
     },
     "rec:1: this is binary content", "a ROS bag, MCAP, ULog"},
    {"utf16", [] { return std::string("\xff\xfet\0,\0a\0", 8); }, "rec: this text is in UTF-16",
     "iconv -f UTF-16"},
    {"picture", [] { return std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16); },
     "rec:", "--map t=NAME"},
    {"huge_line", [] { return kHeader + std::string(50'000'000, '7') + "\n"; },
     "rec:2: this line is longer than 1048576 bytes", "check that this is a CSV file"},
    {"huge_number",
     [] { return kHeader + "0," + std::string(1'000'000, '7') + ",2,3,4,5,6,7,8,9\n"; }, "rec:2:2",
     "leave the field empty"},
    {"huge_header",
     [] {
       std::string h = "t";
       for (int i = 0; i < 100'000; ++i) h += ",c" + std::to_string(i);
       return h + "\n";
     },
     "rec:1: the columns acc_x", "--map acc_x=NAME"},
    {"html", [] { return std::string("<!DOCTYPE html>\n<html><body>404</body></html>\n"); },
     "this is a web page", "download the file itself"},
    {"json", [] { return std::string("{\"a\": [1, 2, 3]}\n"); }, "the fields there are: \"a\"",
     "--map acc=NAME"},
    {"folder",
     {},
     "folder: this is a folder",
     "give the recording",
     "calibrate folder -o out.json"},
    {"truncated_hdf5", [] { return real("02_undisturbed_slow_rotation_B.hdf5", 100'000); },
     "rec: the HDF5 file cannot be opened", "give another copy"},
    {"truncated_hdf5_head", [] { return real("02_undisturbed_slow_rotation_B.hdf5", 600); },
     "rec: the HDF5 file cannot be opened", "give another copy"},
    {"truncated_mat", [] { return real("29_disturbed_stationary_magnet_B.mat", 100'000); },
     "rec: ", ""},
    {"truncated_mat_head", [] { return real("29_disturbed_stationary_magnet_B.mat", 200); },
     "rec: ", ""},
    {"hdf5_signature_only", [] { return std::string("\x89HDF\r\n\x1a\n"); }, "rec: ", ""},
    {"mat_signature_only", [] { return std::string("MATLAB 5.0 MAT-file"); }, "rec: ", ""},
};

const std::vector<Bad> kWrongData{
    {"three_seconds", [] { return csv(Table(good().begin(), good().begin() + 150)); },
     "rec: the recording lasts 3.0 s", "for a minute or more"},
    {"one_sample", [] { return csv(Table(good().begin(), good().begin() + 1)); },
     "rec: ", "turn the sensor"},
    {"no_rotation",
     [] {
       Table t;
       for (int i = 0; i < 15; ++i)
         for (int k = 0; k < 120; ++k) {
           t.push_back(good()[std::size_t(k)]);
           t.back()[0] = double(t.size()) * 0.02;
         }
       return csv(t);
     },
     "rec", "all three"},
    {"constant_axis", [] { return each([](Row& r) { r[5] = 0.0; }); },
     "rec: gyr_y is 0 rad/s in all 3000 samples", "check the logger"},
    {"dead_magnetometer", [] { return each([](Row& r) { r[7] = r[8] = r[9] = 1.0; }); },
     "rec: mag reads (1, 1, 1) uT in all", "check the logger"},
    {"acc_in_g", [] { return scaled(1, 3, 1 / kG); }, "rec: the accelerometer usually reads",
     "--unit acc=g"},
    {"acc_in_mg", [] { return scaled(1, 3, 1e3 / kG); }, "it is in mg", "--unit acc=mg"},
    {"acc_in_counts", [] { return scaled(1, 3, 2048 / kG); }, "counts of the converter",
     "--unit acc="},
    {"acc_without_gravity", [] { return scaled(1, 3, 0.02); }, "without gravity",
     "record the accelerometer itself"},
    {"gyr_in_deg", [] { return scaled(4, 3, 1 / kDeg); }, "seems to be in deg/s",
     "--unit gyr=deg/s"},
    {"gyr_in_mdeg", [] { return scaled(4, 3, 1e3 / kDeg); }, "seems to be in mdeg/s",
     "--unit gyr=mdeg/s"},
    {"mag_in_gauss", [] { return scaled(7, 3, 0.01); }, "gauss", "--unit mag=gauss"},
    {"mag_in_milligauss", [] { return scaled(7, 3, 10); }, "milligauss", "--unit mag=mG"},
    {"mag_in_nanotesla", [] { return scaled(7, 3, 1e3); }, "nanotesla", "--unit mag=nT"},
    {"time_not_in_s", [] { return scaled(0, 1, 1e3); }, "seems to be in ms", "--unit t=ms",
     "calibrate rec -o out.json --unit t=s"},
    {"acc_swapped", [] { return each([](Row& r) { std::swap(r[1], r[2]); }); },
     "accelerometer's axes", "--axes acc=", "info rec"},
    {"acc_x_inverted", [] { return each([](Row& r) { r[1] *= -1; }); }, "accelerometer's axes",
     "--axes acc="},
    {"acc_y_inverted", [] { return each([](Row& r) { r[2] *= -1; }); }, "accelerometer's axes",
     "--axes acc=", "info rec"},
    {"acc_z_inverted", [] { return each([](Row& r) { r[3] *= -1; }); }, "accelerometer's axes",
     "--axes acc=", "info rec"},
    {"gyr_swapped", [] { return each([](Row& r) { std::swap(r[5], r[6]); }); }, "gyroscope's axes",
     "--axes gyr=x,z,y", "info rec"},
    {"gyr_x_inverted", [] { return each([](Row& r) { r[4] *= -1; }); }, "gyroscope's axes",
     "--axes gyr=-x,y,z", "info rec"},
    {"gyr_y_inverted", [] { return each([](Row& r) { r[5] *= -1; }); }, "gyroscope's axes",
     "--axes gyr=x,-y,z", "info rec"},
    {"gyr_z_inverted", [] { return each([](Row& r) { r[6] *= -1; }); }, "gyroscope's axes",
     "--axes gyr=x,y,-z"},
    {"gyr_cyclic",
     [] {
       return each([](Row& r) {
         const double x = r[4];
         r[4] = r[5];
         r[5] = r[6];
         r[6] = x;
       });
     },
     "gyroscope's axes", "--axes gyr=z,x,y", "info rec"},
    {"info_of_turned_axes", [] { return each([](Row& r) { r[3] *= -1; }); },
     "rec: do not calibrate", "", "info rec"},
    {"info_of_wrong_units", [] { return scaled(1, 3, 1 / kG); }, "rec: do not calibrate",
     "--unit acc=g", "info rec"},
    {"diagnose_wrong_units", [] { return scaled(7, 3, 1e3); }, "rec: mag usually reads",
     "--unit mag=nT", "diagnose rec -o out.json"},
};

const std::vector<Bad> kWrongUsage{
    {"map_without_equals", good_text, "--map \"acc_x\" is not understood", "acc_x=ax",
     "calibrate rec -o out.json --map acc_x"},
    {"map_of_no_column", good_text, "rec:1: there is no column \"ax\"", "the columns there are",
     "calibrate rec -o out.json --map acc_x=ax"},
    {"map_to_no_quantity", good_text, "which is no name of ours", "use t, acc_x",
     "calibrate rec -o out.json --map wheel=acc_x"},
    {"map_one_column_twice", good_text, "--map gives column \"q\" twice", "one meaning",
     "calibrate rec --map acc_x=q --map acc_y=q"},
    {"unit_without_equals", good_text, "--unit \"deg/s\" is not understood", "gyr=deg/s",
     "calibrate rec --unit deg/s"},
    {"unit_unknown", good_text, "\"rpm\" is no unit known", "deg/s",
     "calibrate rec --unit gyr=rpm"},
    {"unit_of_no_sensor", good_text, "there is no baro", "t, acc, gyr or mag",
     "calibrate rec --unit baro=Pa"},
    {"unit_negative", good_text, "\"-1\" is no unit known", "m/s^2", "calibrate rec --unit acc=-1"},
    {"axes_twice_the_same", good_text, "\"x,x,z\" does not say", "such as y,-x,z",
     "calibrate rec --axes mag=x,x,z"},
    {"axes_of_no_sensor", good_text, "rec: --axes: there is no sensor \"mag7\"",
     "name acc, gyr, mag", "calibrate rec --axes mag7=x,y,z"},
    {"no_folder_for_the_output", good_text, "nowhere/out.json", "",
     "calibrate rec -o nowhere/out.json"},
    {"full_disk", good_text, "/dev/full", "", "calibrate rec -o /dev/full"},
    {"no_such_option", good_text, "--frobnicate", "", "calibrate rec --frobnicate"},
};

const auto kNameOf = [](const testing::TestParamInfo<Bad>& bad) { return bad.param.name; };
INSTANTIATE_TEST_SUITE_P(NoRecording, BadInput, testing::ValuesIn(kNoRecording), kNameOf);
INSTANTIATE_TEST_SUITE_P(WrongData, BadInput, testing::ValuesIn(kWrongData), kNameOf);
INSTANTIATE_TEST_SUITE_P(WrongUsage, BadInput, testing::ValuesIn(kWrongUsage), kNameOf);

TEST(BadInputs, are_at_least_sixty) {
  EXPECT_GE(kNoRecording.size() + kWrongData.size() + kWrongUsage.size(), 60u);
}

}  // namespace
}  // namespace magimu
