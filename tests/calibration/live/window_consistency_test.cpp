// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/window_consistency.h"

#include <gtest/gtest.h>

namespace magimu {
namespace {

TEST(WindowConsistency, tells_how_much_larger_errors_are_than_the_model_says) {
  WindowConsistency c;
  EXPECT_EQ(c.overdispersion(), 1.0);
  for (const double squares : {270.0, 300.0, 330.0}) c.learn({squares, 30});
  EXPECT_EQ(c.overdispersion(), 1.0) << "three windows are little";
  c.learn({5000.0, 30});  // a magnet passed
  c.learn({310.0, 30});
  EXPECT_NEAR(c.overdispersion(), 310.0 / 30.0, 1e-9);
}

TEST(WindowConsistency, of_small_errors_nobody_is_surer_than_the_model) {
  WindowConsistency c;
  for (int i = 0; i < 10; ++i) c.learn({10.0, 30});
  EXPECT_EQ(c.overdispersion(), 1.0);
}

}  // namespace
}  // namespace magimu
