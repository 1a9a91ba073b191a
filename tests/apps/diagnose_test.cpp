// SPDX-License-Identifier: BSD-3-Clause
// `magimu diagnose` as a user runs it: files, exit codes, silence.
#include <gmock/gmock.h>

#include "tests/apps/program.h"
#include "tests/apps/well_formed.h"

namespace magimu {
namespace {

using nlohmann::json;
using test::Outcome;
using test::Program;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Diagnose, writes_its_file_and_a_page) {
  const Program magimu;
  ASSERT_EQ(magimu("simulate -o rec.csv --motion hand --rate 50 --duration 60 --seed 3").exit_code,
            kDone);
  const Outcome run = magimu("diagnose rec.csv -o d.json --report d.html --json");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_EQ(run.out, magimu.text("d.json"));
  const json file = json::parse(run.out);
  EXPECT_EQ(file["format"], "magimu-diagnosis/1");
  EXPECT_EQ(file["calibration_before"]["format"], "magimu-calibration/1");
  EXPECT_EQ(test::xml_error(magimu.text("d.html")), "");

  const Outcome quiet = magimu("diagnose rec.csv -o q.json -q --motion rotation");
  EXPECT_THAT(quiet.out + quiet.err, IsEmpty());
  EXPECT_EQ(magimu.json("q.json")["calibration_after"]["motion"], "rotation");
}

TEST(Diagnose, tells_whether_a_stored_calibration_still_holds) {
  const Program magimu;
  ASSERT_EQ(magimu("simulate -o rec.csv --motion hand --rate 50 --duration 60 --seed 3").exit_code,
            kDone);
  ASSERT_EQ(magimu("calibrate rec.csv -o cal.json -q --motion rotation").exit_code, kDone);
  const Outcome run =
      magimu("diagnose rec.csv --against cal.json --base cal.json -o d.json --report d.html");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("cal.json still predicts these recordings"));
  const json against = magimu.json("d.json")["against"];
  EXPECT_EQ(against["calibration"], "cal.json");
  EXPECT_EQ(against["changed"], false);
  EXPECT_EQ(against["groups"][0]["group"], "hard_iron");
  EXPECT_EQ(test::xml_error(magimu.text("d.html")), "");
  EXPECT_THAT(magimu.text("d.html"), HasSubstr("Against the stored calibration"));

  const Outcome missing = magimu("diagnose rec.csv --against gone.json");
  EXPECT_EQ(missing.exit_code, kUnusable);
  EXPECT_THAT(missing.err, HasSubstr("gone.json"));
  EXPECT_EQ(magimu("diagnose rec.csv --base rec.csv").exit_code, kUnusable);
  EXPECT_EQ(magimu("diagnose rec.csv --base cal.json --motion rotation").exit_code, kUnusable);
}

TEST(Diagnose, explains_itself_with_an_example) {
  const Outcome run = Program()("diagnose --help");
  EXPECT_EQ(run.exit_code, kDone);
  EXPECT_THAT(run.out, AllOf(HasSubstr("Example: magimu diagnose"), HasSubstr("--report"),
                             HasSubstr("--noise"), HasSubstr("--gravity"), HasSubstr("--motion"),
                             HasSubstr("--gyro-interval"), HasSubstr("--false-alarm-rate"),
                             HasSubstr("--threads"), HasSubstr("--json"), HasSubstr("--quiet")));
}

TEST(Diagnose, refuses_what_it_cannot_use) {
  const Program magimu;
  EXPECT_EQ(magimu("diagnose").exit_code, kUnusable);
  EXPECT_EQ(magimu("diagnose missing.csv").exit_code, kUnusable);
  EXPECT_THAT(magimu("diagnose missing.csv").err, HasSubstr("missing.csv"));
  EXPECT_EQ(magimu("diagnose missing.csv --false-alarm-rate 2").exit_code, kUnusable);
  EXPECT_EQ(magimu("diagnose missing.csv --noise 1 2").exit_code, kUnusable);
}

}  // namespace
}  // namespace magimu
