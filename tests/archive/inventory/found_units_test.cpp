// SPDX-License-Identifier: BSD-3-Clause
// What an archive puts right by itself, and what it leaves to who knows the device.
#include "archive/inventory/found_units.h"

#include <gtest/gtest.h>

#include "sim/simulate.h"

namespace magimu {
namespace {

Recording with_units_of_file(double gyr, double mag) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.duration_s = 60.0;
  Recording r = simulate(options).recording;
  for (Vector3& v : r.gyr.v) v *= gyr;
  for (Vector3& v : r.mag[0].v) v *= mag;
  return r;
}

TEST(FoundUnits, that_the_samples_tell_are_put_right) {
  Recording r = with_units_of_file(180.0 / M_PI, 1.0);
  const std::vector<std::string> done = put_units_right(r);
  ASSERT_EQ(done.size(), 1u);
  EXPECT_EQ(done[0], "--unit gyr=deg/s");
}

// Divided by the field's strength: any factor would give directions, and none is known.
TEST(FoundUnits, that_are_a_guess_are_left_as_they_are) {
  Recording r = with_units_of_file(1.0, 1.0 / 300.0);
  const double before = r.mag[0].v[0][0];
  EXPECT_TRUE(put_units_right(r).empty());
  EXPECT_EQ(r.mag[0].v[0][0], before);
}

}  // namespace
}  // namespace magimu
