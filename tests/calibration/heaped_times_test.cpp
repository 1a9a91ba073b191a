// SPDX-License-Identifier: BSD-3-Clause
// Samples that were stamped when they arrived, in heaps: most intervals are microseconds, and say
// nothing of how many samples there are.
#include <gtest/gtest.h>

#include "calibration/calibrate.h"
#include "calibration/survey/survey.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

Recording heaped() {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 200.0;
  options.duration_s = 20.0;
  options.seed = 6;
  Recording r = simulate(options).recording;
  for (VectorSeries* s : {&r.acc, &r.gyr, &r.mag[0]}) {
    double last = -1.0;
    for (std::size_t k = 0; k < s->size(); ++k) {
      // Heaps of unequal sizes, each stamped with the time of its last sample.
      const std::size_t heap = 15 + 7 * (k / 40 % 3);
      last = std::max(last + 1e-5, s->t[std::min(s->size() - 1, (k / heap + 1) * heap - 1)]);
      s->t[k] = last;
    }
  }
  return r;
}

TEST(HeapedTimes, end_with_an_answer) {
  const Recording r = heaped();
  EXPECT_NO_THROW(survey(r));
  const Calibration c = calibrate(r);
  EXPECT_GT(c.nodes, 100);
}

}  // namespace
}  // namespace magimu
