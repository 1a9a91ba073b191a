// SPDX-License-Identifier: BSD-3-Clause
// `magimu info`, and the options by which foreign files are read.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <sstream>
#include <string>

#include "tests/apps/program.h"

namespace magimu {
namespace {

using nlohmann::json;
using test::Outcome;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

class Info : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(
        magimu_("simulate -o rec.csv --motion hand --rate 50 --duration 60 --seed 3").exit_code, 0);
  }
  json info(const std::string& arguments) const {
    const Outcome run = magimu_("info --json " + arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out);
  }
  test::Program magimu_;
};

TEST_F(Info, says_what_a_good_recording_has_and_can_determine) {
  const Outcome run = magimu_("info rec.csv");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, IsEmpty());
  EXPECT_THAT(run.out, AllOf(HasSubstr("50 Hz"), HasSubstr("Rests: 3"), HasSubstr("axes agree"),
                             HasSubstr("distortion D"), HasSubstr("nothing found"),
                             HasSubstr("It can be calibrated.")));
}

TEST_F(Info, gives_the_same_as_json) {
  const json j = info("rec.csv");
  EXPECT_EQ(j["format"], "magimu-info/1");
  EXPECT_EQ(j["sensors"].size(), 3u);
  EXPECT_EQ(j["sensors"][1]["samples"], 3000);
  EXPECT_NEAR(j["sensors"][2]["rate_hz"].get<double>(), 50.0, 1e-6);
  EXPECT_EQ(j["axes"]["status"], "consistent");
  EXPECT_TRUE(j["usable"].get<bool>());
  EXPECT_TRUE(j["issues"].empty());
  EXPECT_EQ(j["expected"]["sigma"].size(), 19u);
}

// As people write it, with the recording behind.
TEST_F(Info, an_option_that_may_be_repeated_takes_one_word_each_time) {
  for (const char* words : {"info --unit acc=g --unit gyr=deg/s rec.csv",
                            "info --axes mag=y,x,z rec.csv", "info --map acc_x=acc_x rec.csv"}) {
    const Outcome run = magimu_(words);
    EXPECT_NE(run.exit_code, 2) << words << ": " << run.err;
  }
}

// Before any fit: no more than a factor of two from what the fit then reports of white noise.
TEST_F(Info, expects_the_sigmas_that_the_calibration_then_has) {
  const json before = info("rec.csv --motion rotation")["expected"]["sigma"];
  const Outcome run = magimu_("calibrate rec.csv --motion rotation --json --mag-time-offset off");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json after = json::parse(run.out);
  const json& order = after["covariance_model"]["order"].is_array()
                          ? after["covariance_model"]["order"]
                          : after["covariance"]["order"];
  const json& matrix = after["covariance_model"]["matrix"];
  for (std::size_t i = 0; i < order.size(); ++i) {
    const double fitted = std::sqrt(matrix[i][i].get<double>());
    const double expected = before[order[i].get<std::string>()].get<double>();
    EXPECT_GT(expected, 0.5 * fitted) << order[i];
    EXPECT_LT(expected, 2.0 * fitted) << order[i];
  }
}

TEST_F(Info, names_the_motion_that_is_missing) {
  ASSERT_EQ(magimu_("simulate -o short.csv --motion hand --rate 50 --duration 12").exit_code, 0);
  const Outcome run = magimu_("info short.csv");
  EXPECT_THAT(run.out, AllOf(HasSubstr("Missing:"), HasSubstr("never pointed up")));
}

TEST_F(Info, finds_turned_axes_and_its_remedy_works) {
  const Outcome odd = magimu_("info rec.csv --axes gyr=x,y,-z");
  EXPECT_EQ(odd.exit_code, 1);
  EXPECT_THAT(odd.out, HasSubstr("give --axes gyr=x,y,-z"));
  EXPECT_EQ(info("rec.csv --axes gyr=x,y,-z --axes gyr=x,y,-z")["axes"]["status"], "consistent");
}

TEST_F(Info, reads_renamed_columns_and_other_units_as_it_is_told) {
  const std::string text = magimu_.text("rec.csv");
  magimu_.folder().write("own.csv", "clock,u,v,w,p,q,r,b1,b2,b3" + text.substr(text.find('\n')));
  const std::string map =
      " --map t=clock --map acc_x=u --map acc_y=v --map acc_z=w --map gyr_x=p --map gyr_y=q"
      " --map gyr_z=r --map mag_x=b1 --map mag_y=b2 --map mag_z=b3";
  const Outcome run = magimu_("info own.csv" + map);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("columns read: \"clock\" as t, \"u\" as acc_x"));
  const json scaled = info("own.csv --unit mag=2" + map);
  EXPECT_NEAR(scaled["field"]["strength_uT"].get<double>(),
              2.0 * info("rec.csv")["field"]["strength_uT"].get<double>(), 0.1);
}

// 104 samples a second with two decimals of a second.
TEST_F(Info, tells_of_times_in_coarse_steps) {
  ASSERT_EQ(magimu_("simulate -o fine.csv --motion hand --rate 104 --seed 4").exit_code, kDone);
  std::stringstream fine(magimu_.text("fine.csv"));
  std::string coarse, line;
  std::getline(fine, line);
  coarse = line + "\n";
  while (std::getline(fine, line)) {
    const std::size_t comma = line.find(',');
    coarse += fmt::format("{:.2f}{}\n", std::stod(line.substr(0, comma)), line.substr(comma));
  }
  magimu_.folder().write("coarse.csv", coarse);
  const Outcome run = magimu_("info coarse.csv");
  EXPECT_EQ(run.exit_code, kDone);
  EXPECT_THAT(run.out, AllOf(HasSubstr("in steps of 10 ms, which is 104 % of the sampling"),
                             HasSubstr("log more digits"), HasSubstr("It can be calibrated")));
}

TEST_F(Info, looks_at_several_recordings) { EXPECT_EQ(info("rec.csv rec.csv").size(), 2u); }

}  // namespace
}  // namespace magimu
