// SPDX-License-Identifier: BSD-3-Clause
// `magimu stream` with boards as they are: what is wrong with their samples is said within seconds,
// with the option that mends it; with that option the same samples end in `yes`, and nothing is
// said.
#include <gmock/gmock.h>

#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <sstream>

#include "recording/csv/csv.h"
#include "tests/apps/program.h"
#include "tests/recording/turned_board.h"

namespace magimu {
namespace {

using nlohmann::json;
using test::Outcome;
using test::Program;
using testing::HasSubstr;
using testing::Not;

using Row = std::array<double, 10>;  // t, acc, gyr, mag

constexpr double kDeg = M_PI / 180.0;

std::string number(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

class StreamFaults : public testing::Test {
 protected:
  // A board that is turned for 40 s.
  void SetUp() override {
    magimu_.folder().write("rec.csv", csv_text(test::turned_board(40.0)));
    std::istringstream text(magimu_.text("rec.csv"));
    std::string line, field;
    std::getline(text, header_);
    while (std::getline(text, line)) {
      std::istringstream fields(line);
      Row row{};
      for (double& value : row) {
        std::getline(fields, field, ',');
        value = std::stod(field);
      }
      rows_.push_back(row);
    }
  }

  void write(const char* name, const std::function<void(std::size_t, Row&)>& change,
             double until_s = 1e300) const {
    std::string out = header_ + "\n";
    for (std::size_t k = 0; k < rows_.size() && rows_[k][0] <= until_s; ++k) {
      Row row = rows_[k];
      change(k, row);
      for (std::size_t i = 0; i < row.size(); ++i) out += (i > 0 ? "," : "") + number(row[i]);
      out += "\n";
    }
    magimu_.folder().write(name, out);
  }

  Program magimu_;
  std::string header_;
  std::vector<Row> rows_;
};

void scale(Row& row, std::size_t sensor, double factor) {
  for (std::size_t i = 1 + 3 * sensor; i < 4 + 3 * sensor; ++i) row[i] *= factor;
}

TEST_F(StreamFaults, are_said_within_five_seconds_with_the_option_that_mends_them) {
  enum : std::size_t { kAcc, kGyr, kMag };
  struct Case {
    const char* name;
    std::function<void(std::size_t, Row&)> change;
    const char *said, *option;
  };
  const Case cases[] = {
      {"mag in nT", [](std::size_t, Row& r) { scale(r, kMag, 1e3); }, "give the file's unit",
       "--unit mag=nT"},
      {"mag in mG", [](std::size_t, Row& r) { scale(r, kMag, 10.0); }, "give the file's unit",
       "--unit mag=mG"},
      {"mag in gauss", [](std::size_t, Row& r) { scale(r, kMag, 0.01); }, "give the file's unit",
       "--unit mag=gauss"},
      {"acc in g", [](std::size_t, Row& r) { scale(r, kAcc, 1.0 / 9.80665); },
       "give the file's unit", "--unit acc=g"},
      {"gyr in deg/s", [](std::size_t, Row& r) { scale(r, kGyr, 1.0 / kDeg); },
       "give the file's unit", "--unit gyr=deg/s"},
      {"a counter", [](std::size_t k, Row& r) { r[0] = double(k); }, "counts samples", "--rate 80"},
      {"ambiguous times", [](std::size_t k, Row& r) { r[0] = 500.0 * double(k); },
       "--unit t=ms or --unit t=us", "--rate 80"},
      {"stamped on arrival",
       [this](std::size_t k, Row& r) {
         r[0] = rows_[std::min(k / 4 * 4 + 3, rows_.size() - 1)][0] + 1e-4 * double(k % 4);
       },
       "stamped on arrival", "--rate 80"},
      {"acc axes",
       [](std::size_t, Row& r) {
         std::swap(r[1], r[2]);
         r[2] *= -1.0;
       },
       "--axes acc=-y,x,z", "--axes acc=-y,x,z"},
      {"gyr axis", [](std::size_t, Row& r) { r[5] *= -1.0; }, "--axes gyr=x,-y,z",
       "--axes gyr=x,-y,z"},
      {"mag axis", [](std::size_t, Row& r) { r[9] *= -1.0; }, "--axes mag=", "--axes mag=x,y,-z"},
  };
  for (const Case& c : cases) {
    write("first.csv", c.change, 5.2);
    const Outcome first = magimu_("stream first.csv");
    EXPECT_THAT(first.err, HasSubstr(c.said)) << c.name;
    write("all.csv", c.change);
    const Outcome mended = magimu_(std::string("stream all.csv --json -o cal.json ") + c.option);
    EXPECT_EQ(mended.exit_code, kDone) << c.name << ": " << mended.err;
    EXPECT_THAT(mended.err, Not(HasSubstr(c.said))) << c.name;
    EXPECT_EQ(magimu_.json("cal.json")["trust"]["verdict"], "yes") << c.name << mended.err;
  }
}

TEST_F(StreamFaults, times_that_are_recognised_end_as_a_file_does) {
  const std::pair<const char*, std::function<void(std::size_t, Row&)>> cases[] = {
      {"ms", [](std::size_t, Row& r) { r[0] *= 1e3; }},
      {"us", [](std::size_t, Row& r) { r[0] = std::round(r[0] * 1e6); }},
      {"ms", [](std::size_t, Row& r) { r[0] = std::round(1.78e12 + r[0] * 1e3); }},
      {"ns", [](std::size_t, Row& r) { r[0] = std::round(r[0] * 1e9); }},
  };
  for (const auto& [unit, change] : cases) {
    write("all.csv", change);
    const Outcome run = magimu_("stream all.csv -o cal.json");
    EXPECT_EQ(run.exit_code, kDone) << unit << ": " << run.err;
    EXPECT_THAT(run.err, HasSubstr(std::string("is read as ") + unit));
    EXPECT_EQ(magimu_.json("cal.json")["trust"]["verdict"], "yes") << unit << run.err;
  }
}

TEST_F(StreamFaults, that_are_fatal_end_as_calibrate_ends_and_are_shown_on_the_way) {
  write("nT.csv", [](std::size_t, Row& r) { scale(r, 2, 1e3); });
  const Outcome batch = magimu_("calibrate nT.csv");
  const Outcome run = magimu_("stream nT.csv -o cal.json");
  EXPECT_EQ(run.exit_code, batch.exit_code);
  EXPECT_THAT(batch.err, HasSubstr("--unit mag=nT"));
  EXPECT_THAT(run.err, HasSubstr("magimu: nT.csv: "));
  EXPECT_FALSE(magimu_.has("cal.json"));
  std::istringstream lines(run.out);
  json last;
  for (std::string line; std::getline(lines, line);) last = json::parse(line);
  EXPECT_EQ(last["headline"], "Wrong unit");
  EXPECT_THAT(last["guidance"].get<std::string>(), HasSubstr("--unit mag=nT"));
  EXPECT_EQ(last["issues"][0]["kind"], "unit");
  EXPECT_EQ(last["issues"][0]["severity"], "fatal");
  EXPECT_NE(last["phase"], "converged");
  ASSERT_FALSE(last["theta"].is_null());
  EXPECT_EQ(last["theta"]["trust"]["verdict"], "no");
}

TEST_F(StreamFaults, times_that_cannot_be_told_are_shown_without_a_window) {
  write("counter.csv", [](std::size_t k, Row& r) { r[0] = double(k); });
  const Outcome run = magimu_("stream counter.csv");
  EXPECT_EQ(run.exit_code, kUnusable);
  const json line = json::parse(run.out.substr(0, run.out.find('\n')));
  EXPECT_TRUE(line["t"].is_null());
  EXPECT_EQ(line["headline"], "Wrong time");
  EXPECT_THAT(line["guidance"].get<std::string>(), HasSubstr("--rate HZ"));
}

TEST_F(StreamFaults, a_hemisphere_settles_what_no_motion_tells) {
  write("inverted.csv", [](std::size_t, Row& r) { scale(r, 2, -1.0); });
  const Outcome run = magimu_("stream inverted.csv -o cal.json --hemisphere north");
  EXPECT_THAT(run.err, HasSubstr("--axes mag=-x,-y,-z"));
  EXPECT_NE(magimu_.json("cal.json")["trust"]["verdict"], "yes");
  const Outcome mended =
      magimu_("stream inverted.csv -o cal.json --hemisphere north --axes mag=-x,-y,-z");
  EXPECT_EQ(mended.exit_code, kDone) << mended.err;
  EXPECT_EQ(magimu_.json("cal.json")["trust"]["verdict"], "yes") << mended.err;
}

TEST_F(StreamFaults, a_report_is_written_at_the_end) {
  const Outcome run = magimu_("stream rec.csv -o cal.json --report page.html");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  const std::string page = magimu_.text("page.html");
  EXPECT_THAT(page, HasSubstr("<svg"));
  EXPECT_THAT(page, HasSubstr("Length of the readings"));
}

TEST_F(StreamFaults, a_state_read_by_other_options_is_refused) {
  EXPECT_EQ(magimu_("stream rec.csv --state st").exit_code, kDone);
  const Outcome run = magimu_("stream rec.csv --state st --unit mag=nT");
  EXPECT_EQ(run.exit_code, kUnusable);
}

TEST_F(StreamFaults, axes_of_a_sensor_that_is_not_there_are_refused) {
  const Outcome run = magimu_("stream rec.csv --axes mag7=y,x,z");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, HasSubstr("there is no sensor"));
}

// Of an array of two the other one is calibrated, from the first sample on, with or without a
// state, as calibrate does.
TEST_F(StreamFaults, a_magnetometer_that_never_measures_leaves_the_others) {
  std::string all =
      "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag1_x,mag1_y,mag1_z,mag2_x,mag2_y,mag2_z\n";
  std::string half;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    for (std::size_t i = 0; i < 7; ++i) all += number(rows_[k][i]) + ",";
    all += "0,0,0";
    for (std::size_t i = 7; i < 10; ++i) all += "," + number(rows_[k][i]);
    all += "\n";
    if (k == rows_.size() / 2) half = all;
  }
  magimu_.folder().write("all.csv", all);
  magimu_.folder().write("half.csv", half);
  magimu_("stream half.csv --state st");
  const char* const runs[] = {"calibrate all.csv", "stream all.csv", "stream all.csv --state st"};
  for (const char* const command : runs) {
    const Outcome run = magimu_(std::string(command) + " -o cal.json --report page.html");
    EXPECT_EQ(run.exit_code, kDone) << command << run.err;
    const json file = magimu_.json("cal.json");
    EXPECT_EQ(file["trust"]["verdict"], "yes") << command;
    ASSERT_EQ(file["magnetometers"].size(), 1u) << command;
    EXPECT_EQ(file["magnetometers"][0]["name"], "mag2");
    EXPECT_THAT(file["warnings"].dump(), HasSubstr("mag1 is left out: it reads (0, 0, 0) uT"));
    EXPECT_THAT(magimu_.text("page.html"), HasSubstr("Length of the readings"));
    EXPECT_EQ(magimu_("calibrate rec.csv -o alone.json").exit_code, kDone);
    const json alone = magimu_.json("alone.json");
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(file["magnetometers"][0]["bias"][i].get<double>(),
                  alone["magnetometers"][0]["bias"][i].get<double>(), 1e-6)
          << command;
    }
  }
}

// A stream so short that it is seen at the end only.
TEST_F(StreamFaults, a_magnetometer_that_is_found_dead_at_the_end_is_left_out_by_its_name) {
  std::string all =
      "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag1_x,mag1_y,mag1_z,mag2_x,mag2_y,mag2_z\n";
  for (std::size_t k = 0; k < rows_.size() && rows_[k][0] < 1.5; ++k) {
    for (std::size_t i = 0; i < 7; ++i) all += number(rows_[k][i]) + ",";
    all += "0,0,0";
    for (std::size_t i = 7; i < 10; ++i) all += "," + number(rows_[k][i]);
    all += "\n";
  }
  magimu_.folder().write("all.csv", all);
  EXPECT_EQ(magimu_("stream all.csv -o cal.json").exit_code, kNoAnswer);
  const json file = magimu_.json("cal.json");
  ASSERT_EQ(file["magnetometers"].size(), 1u);
  EXPECT_EQ(file["magnetometers"][0]["name"], "mag2");
  EXPECT_THAT(file["trust"]["reasons"].dump(), HasSubstr("too short"));
}

// Its columns are empty.
TEST_F(StreamFaults, a_magnetometer_without_a_sample_leaves_the_others) {
  for (const bool first : {true, false}) {
    std::string all =
        "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag1_x,mag1_y,mag1_z,mag2_x,mag2_y,mag2_z\n";
    for (const Row& row : rows_) {
      for (std::size_t i = 0; i < 7; ++i) all += number(row[i]) + ",";
      if (first) all += ",,,";
      for (std::size_t i = 7; i < 10; ++i) all += (i > 7 ? "," : "") + number(row[i]);
      if (!first) all += ",nan,nan,nan";
      all += "\n";
    }
    magimu_.folder().write("all.csv", all);
    for (const char* const command : {"calibrate all.csv", "stream all.csv"}) {
      const Outcome run = magimu_(std::string(command) + " -o cal.json");
      EXPECT_EQ(run.exit_code, kDone) << command << run.err;
      const json file = magimu_.json("cal.json");
      EXPECT_EQ(file["trust"]["verdict"], "yes") << command;
      ASSERT_EQ(file["magnetometers"].size(), 1u) << command;
      EXPECT_EQ(file["magnetometers"][0]["name"], first ? "mag2" : "mag1");
      EXPECT_THAT(file["warnings"].dump(),
                  HasSubstr(first ? "mag1 is left out" : "mag2 is left out"));
    }
  }
}

TEST_F(StreamFaults, a_magnetometer_that_dies_on_the_way_leaves_what_it_measured) {
  write("died.csv", [this](std::size_t k, Row& r) {
    const std::size_t last = rows_.size() * 3 / 4;
    for (std::size_t i = 7; i < 10; ++i) r[i] = rows_[std::min(k, last)][i];
  });
  for (const char* const command : {"calibrate died.csv", "stream died.csv"}) {
    const Outcome run = magimu_(std::string(command) + " -o cal.json");
    EXPECT_EQ(run.exit_code, kDone) << command << run.err;
    const json file = magimu_.json("cal.json");
    EXPECT_EQ(file["trust"]["verdict"], "limited") << command;
    EXPECT_THAT(file["trust"]["reasons"][0].get<std::string>(),
                HasSubstr("repeated to the last bit"));
  }
}

}  // namespace
}  // namespace magimu
