// SPDX-License-Identifier: BSD-3-Clause
// A calibration that was made with --axes is not used on a recording that is read without.
#include <gmock/gmock.h>

#include "tests/apps/program.h"

namespace magimu {
namespace {

using test::Outcome;
using test::Program;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class AxesOfCalibration : public testing::Test {
 protected:
  AxesOfCalibration() {
    run_("simulate -o rec.csv --truth truth.json --motion hand --rate 50 --duration 40");
    run_("calibrate rec.csv -o turned.json --motion rotation -q --axes mag=y,-x,z");
  }
  Program run_;
};

TEST_F(AxesOfCalibration, are_in_its_file) {
  EXPECT_EQ(run_.json("turned.json")["axes"], (nlohmann::json{{"mag", "y,-x,z"}}));
}

TEST_F(AxesOfCalibration, must_be_given_again_by_whoever_uses_it) {
  for (const char* command :
       {"apply turned.json rec.csv -o out.csv", "diagnose rec.csv --against turned.json",
        "calibrate rec.csv -o again.json --prior turned.json"}) {
    const Outcome without = run_(command);
    EXPECT_EQ(without.exit_code, kUnusable) << command;
    EXPECT_THAT(without.err, HasSubstr("give --axes mag=y,-x,z")) << command;
    const Outcome other = run_(std::string(command) + " --axes mag=-y,x,z");
    EXPECT_EQ(other.exit_code, kUnusable) << command;
  }
  EXPECT_FALSE(run_.has("out.csv"));
  EXPECT_EQ(run_("apply turned.json rec.csv -o out.csv --axes mag=y,-x,z").exit_code, kDone);
}

TEST_F(AxesOfCalibration, are_in_what_is_exported) {
  const Outcome run = run_("export turned.json --to c");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("mag = (y,-x,z)"));
}

TEST_F(AxesOfCalibration, are_known_of_a_calibration_that_comes_through_a_pipe) {
  const auto piped = [&](const std::string& arguments) {
    const std::string command = "cd '" + run_.folder().path("") + "' && cat turned.json | '" +
                                MAGIMU_BINARY + "' " + arguments + " >.said 2>.err";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(piped("apply /dev/stdin rec.csv -o piped.csv"), kUnusable);
  EXPECT_THAT(run_.text(".err"), HasSubstr("give --axes mag=y,-x,z"));
  EXPECT_FALSE(run_.has("piped.csv"));
  EXPECT_EQ(piped("export /dev/stdin --to c"), kDone);
  EXPECT_THAT(run_.text(".said"), HasSubstr("mag = (y,-x,z)"));
}

TEST_F(AxesOfCalibration, are_not_asked_for_where_the_recording_is_said_to_have_the_devices) {
  EXPECT_EQ(run_("apply turned.json rec.csv -o out.csv --axes mag=x,y,z").exit_code, kDone);
}

TEST_F(AxesOfCalibration, that_it_was_made_without_are_refused_too) {
  run_("calibrate rec.csv -o plain.json --motion rotation -q");
  EXPECT_EQ(run_("apply plain.json rec.csv -o out.csv").exit_code, kDone);
  const Outcome turned = run_("apply plain.json rec.csv -o out2.csv --axes mag=y,-x,z");
  EXPECT_THAT(turned.err, AllOf(HasSubstr("leave --axes mag away"), Not(HasSubstr("give"))));
}

}  // namespace
}  // namespace magimu
