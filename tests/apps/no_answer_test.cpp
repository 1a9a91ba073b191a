// SPDX-License-Identifier: BSD-3-Clause
// Data that permit no fit: exit code 1 and a reason from every command that fits, files written all
// the same, and never an internal error.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <sstream>
#include <vector>

#include "tests/apps/program.h"

namespace magimu {
namespace {

using test::Outcome;
using testing::HasSubstr;
using testing::Not;

void expect_no_answer(const Outcome& run, const std::string& reason) {
  EXPECT_EQ(run.exit_code, kNoAnswer) << run.err;
  EXPECT_THAT(run.err, HasSubstr(reason));
  EXPECT_THAT(run.err, Not(HasSubstr("internal error")));
}

// A recording of half a minute in which some lines are changed.
void write_recording(const test::Program& magimu,
                     const std::function<void(int row, std::vector<std::string>& fields)>& change) {
  ASSERT_EQ(
      magimu("simulate -q -o good.csv --motion hand --rate 50 --duration 30 --seed 3").exit_code,
      kDone);
  std::istringstream lines(magimu.text("good.csv"));
  std::ofstream out(magimu.folder().path("rec.csv"));
  std::string line;
  for (int row = -1; std::getline(lines, line); ++row) {
    std::vector<std::string> fields;
    std::istringstream parts(line);
    for (std::string field; std::getline(parts, field, ',');) fields.push_back(field);
    if (row >= 0) change(row, fields);
    for (std::size_t i = 0; i < fields.size(); ++i) out << (i > 0 ? "," : "") << fields[i];
    out << "\n";
  }
}

TEST(NoAnswer, a_noise_density_beyond_double_arithmetic_ends_with_a_reason) {
  const test::Program magimu;
  write_recording(magimu, [](int, auto&) {});
  const std::string noise = " --noise 0.02 8.7e-4 1e-20";
  const Outcome run = magimu("calibrate rec.csv -o cal.json --report r.html --json" + noise);
  expect_no_answer(run, "The noise density given for the magnetometer, 1e-20");
  EXPECT_EQ(magimu.json("cal.json")["trust"]["verdict"], "no");
  EXPECT_EQ(nlohmann::json::parse(run.out), magimu.json("cal.json"));
  EXPECT_TRUE(magimu.has("r.html"));
  expect_no_answer(magimu("diagnose rec.csv -o d.json --report d.html" + noise),
                   "do not permit an answer");
  EXPECT_TRUE(magimu.has("d.json"));
  EXPECT_TRUE(magimu.has("d.html"));
}

// Candidates of the diagnosis diverge there; those have lost, and the others decide.
TEST(NoAnswer, an_axis_that_is_inverted_never_ends_in_an_internal_error) {
  const test::Program magimu;
  write_recording(magimu, [](int, std::vector<std::string>& fields) {
    fields[6] = fields[6].starts_with('-') ? fields[6].substr(1) : "-" + fields[6];
  });
  for (const char* command : {"calibrate", "diagnose"}) {
    const Outcome run = magimu(std::string(command) + " rec.csv");
    EXPECT_THAT(run.exit_code, testing::AnyOf(kDone, kNoAnswer, kUnusable)) << command << run.err;
    EXPECT_THAT(run.err, Not(HasSubstr("internal error")));
  }
}

TEST(NoAnswer, a_gyroscope_that_is_clipped_never_ends_in_an_internal_error) {
  const test::Program magimu;
  write_recording(magimu, [](int, std::vector<std::string>& fields) {
    for (const std::size_t column : {4, 5, 6}) {
      const double rate = std::stod(fields[column]);
      fields[column] = std::to_string(std::min(0.8, std::max(-0.8, rate)));
    }
  });
  for (const char* command : {"calibrate", "diagnose"}) {
    const Outcome run = magimu(std::string(command) + " rec.csv");
    EXPECT_THAT(run.exit_code, testing::AnyOf(kDone, kNoAnswer, kUnusable)) << command << run.err;
    EXPECT_THAT(run.err, Not(HasSubstr("internal error")));
  }
}

TEST(NoAnswer, the_exit_codes_are_listed) {
  const test::Program magimu;
  const Outcome help = magimu("--help");
  EXPECT_THAT(help.out, HasSubstr("70 a defect"));
  for (const char* command :
       {"allan", "apply", "calibrate", "diagnose", "export", "info", "stream"}) {
    EXPECT_THAT(magimu(std::string(command) + " --help").out, HasSubstr("70: a defect")) << command;
  }
}

// A fit of hopeless data may have a distortion that mirrors: its strength is negative.
TEST(NoAnswer, names_an_entry_of_the_distortion_for_people_and_by_how_much_of_the_field) {
  const test::Program magimu;
  ASSERT_EQ(magimu("simulate -q -o rec.csv --motion hand --rate 25 --duration 9 --seed 3 --noise "
                   "0.2 0.02 10")
                .exit_code,
            kDone);
  const std::string said = magimu("calibrate rec.csv").out;
  EXPECT_THAT(said, HasSubstr("The distortion of the magnetometer (D xx) is known to "));
  EXPECT_THAT(said, Not(testing::ContainsRegex("-[0-9]+ % of the field")));
}

}  // namespace
}  // namespace magimu
