// SPDX-License-Identifier: BSD-3-Clause
// A sensor whose bearer walks or rides: that is named, and so is what is hidden beside it.
#include <gmock/gmock.h>

#include "diagnosis/result/diagnosis.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

struct Travelled {
  std::uint64_t seed;
  double speed_mps;
  std::vector<std::string> hidden;
};

class TravelledDiagnosis : public testing::TestWithParam<Travelled> {};

TEST_P(TravelledDiagnosis, names_the_travel_and_what_is_hidden_beside_it) {
  SimulationOptions o;
  o.motion = SimulatedMotion::kHandHeld;
  o.rate_hz = 50.0;
  o.seed = GetParam().seed;
  o.speed_mps = GetParam().speed_mps;
  o.gravity = DiagnosisOptions().gravity;
  std::vector<std::string> expected = {"linear_acceleration"};
  for (const std::string& name : GetParam().hidden) {
    o.effects.push_back({.name = name, .channel = {}, .numbers = {}});
    expected.push_back(name);
  }
  const Diagnosis d = diagnose(simulate(o).recording);
  std::vector<std::string> named;
  for (const Finding& f : d.findings) named.push_back(f.effect);
  EXPECT_EQ(named, expected);
  EXPECT_EQ(d.after.motion, MotionModel::kTravelling);
  EXPECT_EQ(d.answer, Answer::kExplained) << testing::PrintToString(d.evidence);
  EXPECT_THAT(d.findings.front().sentence, testing::HasSubstr("The sensor travelled"));
}

INSTANTIATE_TEST_SUITE_P(Fresh, TravelledDiagnosis,
                         testing::Values(Travelled{47012, 15.0, {}},
                                         Travelled{47013, 1.4, {"mag_time_offset"}},
                                         Travelled{47014, 5.0, {"hard_iron_change"}}),
                         [](const auto& tested) {
                           return "seed_" + std::to_string(tested.param.seed);
                         });

}  // namespace
}  // namespace magimu
