// SPDX-License-Identifier: BSD-3-Clause
// What is done to fast recordings before they are searched must not look like a fault of theirs.
#include <gtest/gtest.h>

#include "diagnosis/result/diagnosis.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

// Noise so low that a mean over 13 ms, or an attitude between two samples that is off by what the
// rate changes meanwhile, would show by tens of standard deviations.
TEST(FastSensors, are_not_said_to_have_filters) {
  for (const std::uint64_t seed : {9121U, 9122U}) {
    SimulationOptions options;
    options.motion = SimulatedMotion::kHand;
    options.rate_hz = 1000.0;
    options.mag_ratio = 10;
    options.duration_s = 40.0;
    options.seed = seed;
    options.noise = NoiseDensities{2e-5, 1e-6, 1e-3};
    options.gravity = DiagnosisOptions().gravity;
    const Diagnosis d = diagnose(simulate(options).recording);
    EXPECT_EQ(to_string(d.answer), std::string("predicts"));
    for (const Finding& f : d.findings) ADD_FAILURE() << f.effect;
  }
}

}  // namespace
}  // namespace magimu
