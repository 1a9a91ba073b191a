// SPDX-License-Identifier: BSD-3-Clause
// magimu simulate --effect as a user types it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/program.h"

namespace magimu {
namespace {

using test::Program;
using testing::HasSubstr;

TEST(SimulateEffects, writes_the_columns_and_the_truth_that_they_need) {
  const Program program;
  const auto run = program(
      "simulate -o rec.csv --truth truth.json --motion hand --rate 50 --duration 30"
      " --effect mag_temperature --effect mag_current=2 --effect hard_iron_change=1:2:3:10:inf"
      " --effect noise_scale@acc=2:");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("noise_scale: s = 2"));
  EXPECT_THAT(program.text("rec.csv").substr(0, 120), HasSubstr(",current,temp"));
  const auto effects = program.json("truth.json")["effects"];
  ASSERT_EQ(effects.size(), 4u);
  EXPECT_EQ(effects[0]["parameters"][0]["unit"], "uT/K");
  EXPECT_EQ(effects[2]["parameters"][3]["value"], 10.0);
  EXPECT_TRUE(effects[2]["parameters"][4]["value"].is_null());
}

TEST(SimulateEffects, refuses_what_it_does_not_know_and_writes_nothing) {
  const Program program;
  for (const char* effect : {"gremlins", "lever_arm=1:2", "mag_lag@acc", "field_gradient"}) {
    const auto run =
        program(std::string("simulate -o rec.csv --truth truth.json --effect ") + effect);
    EXPECT_EQ(run.exit_code, 2) << effect;
    EXPECT_THAT(run.err, HasSubstr("--effect")) << effect;
    EXPECT_FALSE(program.has("rec.csv") || program.has("truth.json")) << effect;
  }
  EXPECT_THAT(program("simulate -o rec.csv --effect gremlins").err, HasSubstr("known are"));
}

}  // namespace
}  // namespace magimu
