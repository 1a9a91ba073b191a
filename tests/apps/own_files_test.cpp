// SPDX-License-Identifier: BSD-3-Clause
// Pages, places, noise files and completion, as a user runs them.
#include <gmock/gmock.h>

#include <sstream>

#include "tests/apps/program.h"
#include "tests/apps/well_formed.h"

namespace magimu {
namespace {

using nlohmann::json;
using test::Outcome;
using test::Program;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

// A page that stands alone: well-formed, without script, and nothing that a browser would fetch.
void expect_stands_alone(const std::string& page) {
  EXPECT_EQ(test::xml_error(page), "");
  for (const char* fetched : {"<script", "src=", "href=", "url(", "@import", "<link", "<iframe",
                              "<img", "<object", "onload", "onclick", "javascript:"}) {
    EXPECT_THAT(page, Not(HasSubstr(fetched)));
  }
  std::string rest = page;  // the names of XML's dialects are the only addresses
  for (const char* dialect : {"http://www.w3.org/1999/xhtml", "http://www.w3.org/2000/svg"}) {
    for (auto at = rest.find(dialect); at != std::string::npos; at = rest.find(dialect)) {
      rest.erase(at, std::string(dialect).size());
    }
  }
  EXPECT_THAT(rest, Not(HasSubstr("://")));
}

TEST(CalibrationReport, is_a_page_that_stands_alone) {
  const Program magimu;
  magimu("simulate -o rec.csv --motion hand --rate 50 --duration 40 --magnetometers 2");
  const Outcome run =
      magimu("calibrate rec.csv --motion rotation --mag-time-offset on --report r.html -q");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const std::string page = magimu.text("r.html");
  expect_stands_alone(page);
  EXPECT_THAT(page,
              AllOf(HasSubstr("This calibration can be used"), HasSubstr("rec.csv"),
                    HasSubstr("The field before and after of mag2"), HasSubstr("Coverage"),
                    HasSubstr("What the model leaves of the mag1"), HasSubstr("Convergence")));
  EXPECT_THAT(page,
              AllOf(HasSubstr("sigma of the model"), HasSubstr("mag2 distortion D zy"),
                    HasSubstr("mag1 lag"), HasSubstr("99 % of noise"), HasSubstr("How to use it")));
  EXPECT_THAT(page, Not(ContainsRegex("[^a-z]nan[^a-z]")));
}

TEST(CalibrationReport, says_so_where_the_calibration_must_not_be_used) {
  const Program magimu;
  magimu("simulate -o rec.csv --motion hand --rate 50 --rest 19 --duration 20");
  const Outcome run = magimu("calibrate rec.csv --report r.html -q");
  EXPECT_EQ(run.exit_code, kNoAnswer);
  const std::string page = magimu.text("r.html");
  expect_stands_alone(page);
  EXPECT_THAT(page, AllOf(HasSubstr("Do not use this calibration"), Not(HasSubstr("How to use"))));
}

TEST(Location, checks_strength_and_dip_and_gives_the_declination) {
  const Program magimu;
  magimu("simulate -o rec.csv --truth truth.json --motion hand --rate 50 --duration 40");
  const Outcome run =
      magimu("calibrate rec.csv -o cal.json --motion rotation --location 52.5,13.4,34,2026-07-01");
  EXPECT_THAT(run.out, AllOf(HasSubstr("WMM2025 at this place"), HasSubstr("declination")));
  const json location = magimu.json("cal.json")["location"];
  EXPECT_EQ(location["model"], "WMM2025");
  EXPECT_NEAR(location["dip_deg"], 68.1, 0.3);
  EXPECT_NEAR(magimu.json("cal.json")["gravity"], 9.8127, 1e-3);
  const Outcome wrong = magimu("calibrate rec.csv --location 52.5,13.4,1999-01-01");
  EXPECT_EQ(wrong.exit_code, kUnusable);
  EXPECT_THAT(wrong.err, HasSubstr("2020"));
  EXPECT_EQ(magimu("calibrate rec.csv --field-prior").exit_code, kUnusable);
  const bool north = magimu.json("truth.json")["field"]["dip_deg"] > 0.0;
  const std::string other = north ? "south" : "north";
  const Outcome inverted = magimu("calibrate rec.csv --motion rotation --hemisphere " + other);
  EXPECT_EQ(inverted.exit_code, kNoAnswer);
  EXPECT_THAT(inverted.err, HasSubstr("an odd number of axes is inverted"));
  EXPECT_THAT(magimu("info rec.csv").out, HasSubstr("no motion can tell"));
  EXPECT_THAT(magimu("info rec.csv --hemisphere " + other).out, HasSubstr("--axes mag=-x,-y,-z"));
  EXPECT_THAT(magimu("info rec.csv --hemisphere " + std::string(north ? "north" : "south")).out,
              AllOf(HasSubstr("axes agree"), Not(HasSubstr("dip of"))));
}

TEST(Prior, is_what_is_usual_nothing_or_an_older_calibration) {
  const Program magimu;
  magimu("simulate -o rec.csv --motion hand --rate 50 --duration 60");
  ASSERT_EQ(magimu("calibrate rec.csv -o old.json -q").exit_code, kDone);
  EXPECT_EQ(magimu.json("old.json")["prior"]["source"], "default");
  ASSERT_EQ(magimu("calibrate rec.csv --prior none -o none.json -q").exit_code, kDone);
  EXPECT_EQ(magimu.json("none.json")["prior"]["source"], "none");
  ASSERT_EQ(magimu("calibrate rec.csv --prior old.json -o new.json -q").exit_code, kDone);
  const json prior = magimu.json("new.json")["prior"];
  EXPECT_EQ(prior["source"], "old.json");
  EXPECT_EQ(prior["parameters"].size(), 18U);
  for (const json& p : prior["parameters"]) {
    EXPECT_LE(p["sigma_after"].get<double>(), 1.01 * p["sigma_before"].get<double>()) << p["name"];
  }
  EXPECT_EQ(magimu("stream rec.csv --prior old.json -o stream.json -q").exit_code, kDone);
  EXPECT_EQ(magimu.json("stream.json")["prior"]["source"], "old.json");
  EXPECT_EQ(magimu("calibrate rec.csv --prior missing.json").exit_code, kUnusable);
  const Outcome age = magimu("calibrate rec.csv --prior-age 3");
  EXPECT_EQ(age.exit_code, kUnusable);
  EXPECT_THAT(age.err, HasSubstr("--prior CAL.json"));
}

// A device that lies still but for the last seconds; the noise is simulate's.
TEST(Allan, finds_the_densities_and_calibrate_takes_them) {
  const Program magimu;
  magimu("simulate -o rest.csv --motion hand --rest 290 --duration 300 --rate 100");
  const Outcome run = magimu("allan rest.csv -o noise.json --report r.html");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("White noise of"), HasSubstr("Bias instability"),
                             HasSubstr("Random walk of the bias")));
  expect_stands_alone(magimu.text("r.html"));
  const json noise = magimu.json("noise.json");
  EXPECT_EQ(noise["format"], "magimu-noise/1");
  EXPECT_NEAR(noise["noise"]["acc"].get<double>() / 0.02, 1.0, 0.03);
  EXPECT_NEAR(noise["noise"]["gyro"].get<double>() / 8.7266e-4, 1.0, 0.03);
  EXPECT_NEAR(noise["noise"]["mag"].get<double>() / 0.003, 1.0, 0.03);
  magimu("simulate -o rec.csv --motion hand --rate 50 --duration 40");
  const Outcome with = magimu("calibrate --noise noise.json rec.csv -o cal.json -q");
  EXPECT_EQ(with.exit_code, kDone) << with.err;
  const json used = magimu.json("cal.json")["noise"];
  EXPECT_EQ(used["acc"], noise["noise"]["acc"]);
  EXPECT_EQ(used["source"], "given");
  EXPECT_EQ(magimu("calibrate rec.csv --noise rec.csv -q").exit_code, kUnusable);
}

TEST(Allan, refuses_a_device_that_moves_and_says_when) {
  const Program magimu;
  magimu("simulate -o rec.csv --motion hand --rate 50 --duration 40");
  const Outcome run = magimu("allan rec.csv -o noise.json");
  EXPECT_EQ(run.exit_code, kNoAnswer);
  EXPECT_THAT(run.err, AllOf(HasSubstr("The device moves ("), HasSubstr(" s); the longest rest"),
                             HasSubstr("a minute gives the white noise")));
  EXPECT_FALSE(magimu.has("noise.json"));
}

TEST(Version, has_the_facts_of_the_build) {
  const Program magimu;
  const Outcome run = magimu("--version");
  EXPECT_EQ(run.exit_code, kDone);
  EXPECT_THAT(run.out, AllOf(testing::StartsWith("magimu "), HasSubstr("compiler: "),
                             HasSubstr("build type: "), HasSubstr("SuiteSparse: ")));
}

TEST(Completion, names_every_subcommand_of_the_help) {
  const Program magimu;
  const std::string script = magimu("completion").out;
  std::istringstream help(magimu("--help").out);
  int commands = 0;
  bool inside = false;
  for (std::string line; std::getline(help, line);) {
    if (line.starts_with("Subcommands:")) inside = true;
    if (!inside || !line.starts_with("  ") || line.starts_with("   ")) continue;
    const std::string name = line.substr(2, line.find(' ', 2) - 2);
    EXPECT_THAT(script, HasSubstr(" " + name + ") words=")) << name;
    ++commands;
  }
  EXPECT_GE(commands, 7);
}

}  // namespace
}  // namespace magimu
