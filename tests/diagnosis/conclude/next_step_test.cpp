// SPDX-License-Identifier: BSD-3-Clause
// What to do next follows from where something is left.
#include "diagnosis/conclude/next_step.h"

#include <gmock/gmock.h>

#include "tests/diagnosis/example_diagnosis.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Something is missing in the sensor with this process.
std::string step_where_missing(const char* channel, const char* frame) {
  Diagnosis d = test::clean_diagnosis();
  for (const auto& [c, f] : {std::pair("mag", "navigation"), std::pair("mag", "sensor"),
                             std::pair("gyr", "sensor"), std::pair("acc", "sensor")}) {
    const bool here = std::string(c) == channel && std::string(f) == frame;
    d.missing.push_back({.channel = c,
                         .frame = f,
                         .unit = "uT",
                         .gain_nats = here ? 100.0 : 20.0,
                         .left_nats = here ? 100.0 : 20.0,
                         .size = 0.1,
                         .memory_s = 1.0});
  }
  return test::concluded(std::move(d)).next_step;
}

TEST(NextStep, of_a_field_that_differs_is_another_place) {
  EXPECT_THAT(step_where_missing("mag", "navigation"), HasSubstr("away from iron"));
}

TEST(NextStep, of_anything_else_does_not_send_away_from_iron) {
  EXPECT_THAT(step_where_missing("mag", "sensor"),
              AllOf(HasSubstr("beside the magnetometer"), Not(HasSubstr("away from iron"))));
  EXPECT_THAT(step_where_missing("gyr", "sensor"),
              AllOf(HasSubstr("the gyroscope's settings"), Not(HasSubstr("away from iron"))));
  EXPECT_THAT(step_where_missing("acc", "sensor"),
              AllOf(HasSubstr("six faces"), Not(HasSubstr("away from iron"))));
}

TEST(NextStep, begins_with_the_samples_that_a_sensor_lost) {
  Diagnosis d = test::unexplained_diagnosis();
  d.after.set_aside = {{"hand.csv", {"gyr", "stuck", 800, 6000, 12.3, 20.3, "gyr = (1, 2, 3)"}}};
  d = test::concluded(std::move(d));
  EXPECT_THAT(d.next_step, AllOf(HasSubstr("First mend what has lost samples (gyr: the sensor or "
                                           "its bus hung"),
                                 Not(HasSubstr("away from iron"))));
}

TEST(NextStep, is_nothing_where_nothing_is_left) {
  EXPECT_EQ(test::clean_diagnosis().next_step, "");
}

TEST(NextStep, says_whether_the_standard_deviations_know) {
  Diagnosis d = test::unexplained_diagnosis();
  EXPECT_THAT(what_sigmas_know(d), HasSubstr("do not know of it"));
  d.before.checks.push_back({"model", CheckStatus::kCaution, 5.0, "Something is missing."});
  EXPECT_THAT(what_sigmas_know(d), HasSubstr("are widened"));
}

}  // namespace
}  // namespace magimu
