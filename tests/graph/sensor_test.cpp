// SPDX-License-Identifier: BSD-3-Clause
#include "graph/sensor.h"

#include <gtest/gtest.h>

namespace magimu {
namespace {

TEST(Sensors, are_found_by_the_names_that_they_have) {
  for (const Sensor sensor : kSensors) {
    EXPECT_EQ(sensor_named(to_string(sensor)), sensor);
    EXPECT_EQ(in_words(to_string(sensor)), in_words(sensor));
  }
  EXPECT_EQ(sensor_named("mag2"), Sensor::kMag);
  EXPECT_EQ(in_words("mag2"), "mag2");
  EXPECT_STREQ(unit_of(Sensor::kGyr), "rad/s");
  EXPECT_EQ(to_string(Sensor::kReach), "reach");
}

TEST(Sensors, of_rows_of_a_graph_are_all_but_none) {
  EXPECT_EQ(kSensors.size(), 3u);
  EXPECT_EQ(kMeasuring, std::size_t(Sensor::kNone));
}

}  // namespace
}  // namespace magimu
