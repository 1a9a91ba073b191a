// SPDX-License-Identifier: BSD-3-Clause
// The gate and simulated recordings: all motions, rates from 20 Hz to 1 kHz, with what a diagnosis
// must still be able to find.
#include "recording/checks/gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "recording/data/set_aside.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

Recording simulated(SimulatedMotion motion, double rate, std::uint64_t seed,
                    const std::string& effect = "") {
  SimulationOptions options;
  options.motion = motion;
  options.rate_hz = rate;
  options.seed = seed;
  options.duration_s = 60.0;
  if (!effect.empty()) options.effects = {parse_effect_request(effect)};
  return simulate(options).recording;
}

void expect_untouched(const Recording& r, const std::string& what) {
  const std::optional<Recording> kept = gated(r);
  if (!kept) return;
  for (const SetAside& s : kept->set_aside) ADD_FAILURE() << what << ": " << sentence(s);
}

constexpr SimulatedMotion kMotions[] = {SimulatedMotion::kPaper, SimulatedMotion::kHand,
                                        SimulatedMotion::kHandHeld};

TEST(GateOfSimulations, sets_nothing_aside_of_clean_ones_at_any_rate) {
  for (const SimulatedMotion motion : kMotions) {
    for (const double rate : {20.0, 50.0, 100.0, 400.0, 1000.0}) {
      expect_untouched(simulated(motion, rate, 1 + std::uint64_t(rate)), to_string(motion));
    }
  }
}

TEST(GateOfSimulations, leaves_effects_to_the_diagnosis) {
  for (const char* effect :
       {"outliers", "outliers=10", "outliers@acc", "outliers@gyr=3", "hard_iron_change=3",
        "mains_interference=3", "mag_current=3", "mag_quantization=5", "correlated_noise@acc",
        "noise_scale@gyr=3", "stationary_source"}) {
    for (const double rate : {20.0, 100.0}) {
      expect_untouched(simulated(SimulatedMotion::kHandHeld, rate, 5, effect), effect);
    }
  }
}

// One sample in five hundred, as a mean of several would hide it; at any rate.
TEST(GateOfSimulations, finds_readings_of_another_time) {
  std::mt19937 bits(6);
  for (const double rate : {50.0, 100.0, 1000.0}) {
    for (const SimulatedMotion motion : kMotions) {
      Recording r = simulated(motion, rate, 40 + std::uint64_t(rate));
      VectorSeries& s = r.mag[0];
      const VectorSeries own = s;
      std::size_t far = 0, bad = 0;
      for (std::size_t k = 250; k + 10 < s.size(); k += 500, ++bad) {
        s.v[k] = own.v[bits() % own.size()];
        far += (s.v[k] - own.v[k]).cwiseAbs().maxCoeff() > 10.0 ? 1 : 0;
      }
      const std::optional<Recording> kept = gated(r);
      ASSERT_TRUE(kept);
      ASSERT_EQ(kept->set_aside.size(), 1u);
      EXPECT_EQ(kept->set_aside[0].sensor, "mag");
      EXPECT_GE(kept->set_aside[0].count, far) << rate << ' ' << to_string(motion);
      EXPECT_LE(kept->set_aside[0].count, bad);
    }
  }
}

// One sample of one axis, multiplied as by a lost decimal point: found wherever it is.
TEST(GateOfSimulations, finds_a_lost_decimal_point_anywhere) {
  std::mt19937 bits(4);
  for (const double rate : {20.0, 100.0, 400.0}) {
    const Recording clean = simulated(SimulatedMotion::kHandHeld, rate, 3);
    for (int trial = 0; trial < 24; ++trial) {
      Recording r = clean;
      VectorSeries& s = trial % 3 == 0 ? r.acc : trial % 3 == 1 ? r.gyr : r.mag[0];
      const std::size_t k = bits() % s.size();
      int axis = 0;
      s.v[k].cwiseAbs().maxCoeff(&axis);
      s.v[k][axis] *= 1e4;
      const std::optional<Recording> kept = gated(r);
      ASSERT_TRUE(kept) << "rate " << rate << ", sample " << k << ": " << s.v[k].transpose();
      ASSERT_EQ(kept->set_aside.size(), 1u);
      EXPECT_EQ(kept->set_aside[0].count, 1u);
      EXPECT_DOUBLE_EQ(kept->set_aside[0].begin_s, s.t[k]);
    }
  }
}

}  // namespace
}  // namespace magimu
