// SPDX-License-Identifier: BSD-3-Clause
// `magimu simulate --like`: a replica has the causes that the diagnosis found, at their sizes, and
// no others; one of the model without causes is predicted by it.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/apps/program.h"

namespace magimu::apps {
namespace {

using test::Outcome;
using test::Program;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

std::map<std::string, std::vector<double>> causes(const nlohmann::json& diagnosis) {
  std::map<std::string, std::vector<double>> out;
  for (const auto& finding : diagnosis["findings"]) {
    for (const auto& p : finding["parameters"]) {
      out[finding["effect"]].push_back(p["value"].is_number() ? p["value"].get<double>()
                                                              : INFINITY);
    }
  }
  return out;
}

TEST(Replica, has_the_causes_that_were_found) {
  const Program magimu;
  ASSERT_EQ(magimu("simulate -q -o rec.csv --motion hand --rate 50 --duration 60 --seed 4 "
                   "--effect hard_iron_change=0.9:-0.6:0.5:25:inf")
                .exit_code,
            kDone);
  ASSERT_EQ(magimu("diagnose -q rec.csv -o diag.json").exit_code, kDone);
  const auto found = causes(magimu.json("diag.json"));
  ASSERT_EQ(found.count("hard_iron_change"), 1u);
  const Outcome run = magimu("simulate --like rec.csv --model diag.json -o replica.csv --seed 9");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("hard_iron_change"));
  ASSERT_EQ(magimu("diagnose -q replica.csv -o again.json").exit_code, kDone);
  const auto again = causes(magimu.json("again.json"));
  ASSERT_EQ(again.size(), 1u);
  ASSERT_EQ(again.count("hard_iron_change"), 1u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(again.at("hard_iron_change")[std::size_t(i)],
                found.at("hard_iron_change")[std::size_t(i)], 0.02);
  }
  // A lasting change is on where the bias is the larger, before or after it.
  const auto time = [](const std::vector<double>& p) {
    return std::isfinite(p[3]) && p[3] > 0.0 ? p[3] : p[4];
  };
  EXPECT_NEAR(time(again.at("hard_iron_change")), 25.0, 0.1);
}

TEST(Replica, of_the_model_without_causes_is_predicted_by_it) {
  const Program magimu;
  ASSERT_EQ(
      magimu("simulate -q -o rec.csv --motion hand --rate 50 --duration 60 --seed 5").exit_code,
      kDone);
  ASSERT_EQ(magimu("simulate -q --like rec.csv -o replica.csv").exit_code, kDone);
  ASSERT_EQ(magimu("diagnose -q replica.csv -o diag.json").exit_code, kDone);
  EXPECT_EQ(magimu.json("diag.json")["answer"], "predicts");
}

TEST(Replica, has_the_field_of_the_place_that_was_found) {
  const Program magimu;
  // Of a sensor good enough that the first fit's positions are those of the hand.
  ASSERT_EQ(magimu("simulate -q -o rec.csv --motion hand_held --rate 50 --duration 70 --seed 11 "
                   "--room 11 --rest 5 --displacement 0.1 --noise 5e-4 2e-5 0.02")
                .exit_code,
            kDone);
  ASSERT_EQ(magimu("diagnose -q rec.csv -o diag.json").exit_code, kDone);
  const auto found = causes(magimu.json("diag.json"));
  ASSERT_EQ(found.count("field_departure"), 1u);
  ASSERT_EQ(
      magimu("simulate -q --like rec.csv --model diag.json -o replica.csv --seed 9").exit_code,
      kDone);
  ASSERT_EQ(magimu("diagnose -q replica.csv -o again.json").exit_code, kDone);
  const auto again = causes(magimu.json("again.json"));
  ASSERT_EQ(again.count("field_departure"), 1u);
  // Root mean square along the path, uT.
  EXPECT_NEAR(again.at("field_departure")[0], found.at("field_departure")[0],
              0.2 * found.at("field_departure")[0]);
}

TEST(Replica, wrong_usage_says_what_is_wrong) {
  const Program magimu;
  magimu.folder().write("no.json", "{\"format\": \"magimu-calibration/1\"}");
  ASSERT_EQ(magimu("simulate -q -o rec.csv --motion hand --rate 50 --duration 30").exit_code,
            kDone);
  const Outcome other = magimu("simulate --like rec.csv --model no.json -o replica.csv");
  EXPECT_EQ(other.exit_code, kUnusable);
  EXPECT_THAT(other.err, HasSubstr("it is no diagnosis with a model"));
  EXPECT_THAT(magimu("simulate --like rec.csv --rate 20 -o replica.csv").err, HasSubstr("--rate"));
  EXPECT_THAT(magimu("simulate --model no.json -o replica.csv").err, HasSubstr("--like"));
}

}  // namespace
}  // namespace magimu::apps
