// SPDX-License-Identifier: BSD-3-Clause
// `magimu apply` and `magimu export` as a user runs them.
#include <gmock/gmock.h>

#include "tests/apps/program.h"

namespace magimu {
namespace {

using nlohmann::json;
using test::Outcome;
using test::Program;
using testing::AllOf;
using testing::HasSubstr;

// rec.csv of a sensor turned for 40 s, and its calibration cal.json.
class Apply : public testing::Test {
 protected:
  static const Program& calibrated() {
    static const Program* const program = [] {
      auto* p = new Program;
      (*p)("simulate -o rec.csv --truth truth.json --motion hand --rate 50 --duration 40");
      (*p)("calibrate rec.csv -o cal.json --motion rotation -q");
      return p;
    }();
    return *program;
  }
  static void SetUpTestSuite() { ASSERT_TRUE(calibrated().has("cal.json")); }

  // A copy of the calibration, changed.
  static std::string changed(const std::string& name, const std::function<void(json&)>& change) {
    json cal = calibrated().json("cal.json");
    change(cal);
    calibrated().folder().write(name, cal.dump());
    return name;
  }
  static void reject(json& cal) {
    cal["trust"] = {{"verdict", "no"}, {"reasons", {"The sensor hardly turned."}}};
  }
};

TEST_F(Apply, corrects_a_recording_and_prints_the_formula) {
  const Outcome run = calibrated()("apply cal.json rec.csv -o out.csv");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("acc_cal = acc - o_a"), HasSubstr("s D^-1")));
  const Outcome again = calibrated()("calibrate out.csv -o again.json --motion rotation -q");
  EXPECT_EQ(again.exit_code, kDone) << again.err;
  const json first = calibrated().json("cal.json"), second = calibrated().json("again.json");
  const double s = first["field"]["strength_uT"];
  for (std::size_t i = 0; i < 3; ++i) {
    // Nothing is left to correct, to the estimate's own accuracy.
    EXPECT_NEAR(second["gyroscope"]["bias"][i], 0.0, 1e-5);
    EXPECT_NEAR(second["magnetometers"][0]["bias"][i], 0.0, 1e-2);
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_NEAR(second["magnetometers"][0]["distortion"][i][j], i == j ? s : 0.0, 2e-2);
    }
  }
}

TEST_F(Apply, names_the_option_that_keeps_magnetometer_samples_in_their_rows) {
  const std::string lagging = changed("lagging.json", [](json& cal) {
    const json lag = {
        {"name", "lag"}, {"value", 0.0123}, {"sigma", 1e-4}, {"sigma_model", 1e-4}, {"unit", "s"}};
    cal["effects"] = {{{"name", "mag_time_offset"}, {"parameters", json::array({lag})}}};
  });
  const Outcome moved = calibrated()("apply " + lagging + " rec.csv -o out.csv");
  EXPECT_EQ(moved.exit_code, kDone) << moved.err;
  EXPECT_THAT(moved.out, HasSubstr("--keep-times leaves them in the rows where they were"));
  const Outcome kept = calibrated()("apply " + lagging + " rec.csv -o out.csv --keep-times");
  EXPECT_THAT(kept.out, testing::Not(HasSubstr("in rows of their own")));
}

TEST_F(Apply, refuses_a_calibration_that_must_not_be_used_unless_forced) {
  const std::string bad = changed("bad.json", reject);
  const Outcome run = calibrated()("apply bad.json rec.csv -o refused.csv");
  EXPECT_EQ(run.exit_code, kNoAnswer);
  EXPECT_THAT(run.err, AllOf(HasSubstr("--force"), HasSubstr("The sensor hardly turned.")));
  EXPECT_FALSE(calibrated().has("refused.csv"));
  EXPECT_EQ(calibrated()("apply bad.json rec.csv -o forced.csv --force").exit_code, kDone);
  EXPECT_TRUE(calibrated().has("forced.csv"));
}

TEST_F(Apply, keeps_its_words_out_of_the_data) {
  const Outcome run = calibrated()("apply cal.json rec.csv -o /dev/stdout");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, testing::StartsWith("t,acc_x"));
  EXPECT_THAT(run.err, HasSubstr("s D^-1"));
  const Outcome as_json = calibrated()("apply cal.json rec.csv -o out.csv --json");
  EXPECT_TRUE(json::parse(as_json.out)["formulas"].is_array());
  const Outcome quiet = calibrated()("apply cal.json rec.csv -o out.csv -q");
  EXPECT_EQ(quiet.out + quiet.err, "");
}

TEST_F(Apply, tells_which_input_it_cannot_use) {
  EXPECT_EQ(calibrated()("apply cal.json rec.csv").exit_code, kUnusable);
  Outcome run = calibrated()("apply missing.json rec.csv -o out.csv");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, HasSubstr("missing.json"));
  run = calibrated()("apply rec.csv cal.json -o out.csv");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, AllOf(HasSubstr("rec.csv:1:"), HasSubstr("magimu calibrate -o")));
}

using Export = Apply;

TEST_F(Export, writes_for_every_target_it_names) {
  for (const char* target : {"px4", "ardupilot", "ros", "matlab", "c"}) {
    const std::string to = target;
    const Outcome run = calibrated()("export cal.json --to " + to);
    EXPECT_EQ(run.exit_code, kDone) << run.err;
    EXPECT_THAT(run.out, HasSubstr("its verdict: "));
    EXPECT_EQ(calibrated()("export cal.json -q --to " + to + " -o " + to + ".out").err, "");
    EXPECT_EQ(calibrated().text(to + ".out"), run.out);
    const Outcome as_json = calibrated()("export cal.json --json --to " + to);
    EXPECT_EQ(json::parse(as_json.out)["text"], run.out);
  }
  const Outcome unknown = calibrated()("export cal.json --to betaflight");
  EXPECT_EQ(unknown.exit_code, kUnusable);
  EXPECT_THAT(unknown.err, HasSubstr("px4"));
}

TEST_F(Export, says_what_the_target_cannot_hold) {
  const Outcome run = calibrated()("export cal.json --to px4");
  EXPECT_THAT(run.err, AllOf(HasSubstr("not carried to px4"), HasSubstr("--with-rotation")));
  EXPECT_THAT(run.out, HasSubstr("LOST: the rotation"));
}

TEST_F(Export, refuses_a_file_that_would_make_headings_wrong_unless_the_loss_is_allowed) {
  const std::string turned = changed("turned.json", [](json& cal) {
    for (json& row : cal["magnetometers"][0]["distortion"]) {
      row = {row[1], row[0], -row[2].get<double>()};
    }
  });
  const Outcome run = calibrated()("export " + turned + " --to px4 -o turned.params");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, AllOf(HasSubstr("--axes mag=y,x,-z"), HasSubstr("--with-rotation"),
                             HasSubstr("--allow-loss")));
  EXPECT_FALSE(calibrated().has("turned.params"));
  for (const char* allowed : {" --to px4 --allow-loss", " --to px4 --with-rotation", " --to c"}) {
    EXPECT_EQ(calibrated()("export " + turned + allowed).exit_code, kDone) << allowed;
  }
}

TEST_F(Export, refuses_a_calibration_that_must_not_be_used_unless_forced) {
  const std::string bad = changed("bad.json", reject);
  EXPECT_EQ(calibrated()("export bad.json --to c -o bad.h").exit_code, kNoAnswer);
  EXPECT_FALSE(calibrated().has("bad.h"));
  EXPECT_EQ(calibrated()("export bad.json --to c -o bad.h --force").exit_code, kDone);
  EXPECT_THAT(calibrated().text("bad.h"), HasSubstr("its verdict: no"));
}

}  // namespace
}  // namespace magimu
