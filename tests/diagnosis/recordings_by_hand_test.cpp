// SPDX-License-Identifier: BSD-3-Clause
// Recordings that a program puts together in memory
// (tests/calibration/recordings_by_hand_test.cpp).
#include <gmock/gmock.h>

#include "diagnosis/result/diagnosis.h"
#include "recording/data/error.h"
#include "sim/simulate.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

Recording seconds(double duration_s) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 50.0;
  options.duration_s = duration_s;
  return simulate(options).recording;
}

TEST(DiagnosedByHand, need_no_names_of_magnetometers) {
  Recording r = seconds(3.0);  // too short for more
  r.mag_names.clear();
  const Diagnosis d = diagnose(r);
  EXPECT_EQ(d.before.mag_names, std::vector<std::string>{"mag"});
}

TEST(DiagnosedByHand, are_refused_where_times_and_values_differ_in_number) {
  Recording r = seconds(60.0);
  r.mag[0].v.pop_back();
  EXPECT_THAT(test::error_of([&] { diagnose(r); }).what(), testing::HasSubstr(" times and "));
}

}  // namespace
}  // namespace magimu
