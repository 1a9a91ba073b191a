// SPDX-License-Identifier: BSD-3-Clause
// A field that differs from place to place is named where the place confirms it, and nowhere else.
#include "diagnosis/conclude/place.h"

#include <gmock/gmock.h>

#include <random>

#include "diagnosis/conclude/missing_state.h"
#include "diagnosis/result/diagnosis_json.h"
#include "sim/simulate.h"
#include "tests/diagnosis/example_diagnosis.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

PlaceCheck confirmed() {
  PlaceCheck p;
  p.asked = p.ahead = p.stays = p.comes_back = true;
  p.order = 2;
  p.field_uT = 0.4;
  p.gradient_uT_m = 3.0;
  p.process_nats = 1000.0;
  p.left_nats = 150.0;
  p.ahead_nats = 600.0;
  p.rival = "a process of the magnetometer";
  p.nll_process = 500.0;
  p.nll_place = 80.0;
  p.blocks = 5;
  p.blocks_better = 5;
  p.block_s = 24.0;
  return p;
}

// Field, magnetometer.
Diagnosis with_field(const PlaceCheck& p) {
  Diagnosis d = test::clean_diagnosis();
  d.missing = {{"mag", "navigation", "uT", 1000.0, 1000.0, 0.0, 0.3, 5.0, ""},
               {"mag", "sensor", "uT", 990.0, 990.0, 0.0, 0.3, 5.0, ""}};
  d.field_at_rest = AtRest{2, 0.1, 1.5, 10.0, 20.0, "hand.csv"};
  d.place = p;
  return d;
}

TEST(Place, says_which_of_the_three_failed_and_what_would_settle_it) {
  EXPECT_EQ(what_would_settle_it(with_field(confirmed())), "") << "it is named";
  PlaceCheck p = confirmed();
  p.comes_back = false;
  p.nll_place = 520.0;
  EXPECT_THAT(what_would_settle_it(with_field(p)),
              AllOf(HasSubstr("not shown: 5 blocks"), HasSubstr("20 nats worse"),
                    Not(HasSubstr("explains the readings")), Not(HasSubstr("lay the sensor down")),
                    HasSubstr("to and fro")));
  p = confirmed();
  p.stays = false;
  Diagnosis d = with_field(p);
  d.field_at_rest->change_sigmas = 9.0;
  EXPECT_THAT(
      what_would_settle_it(d),
      AllOf(HasSubstr("not shown: while the sensor rested, 10 to 20 s"), HasSubstr("9 standard"),
            HasSubstr("lay the sensor down"), Not(HasSubstr("to and fro"))));
  d.field_at_rest.reset();
  EXPECT_THAT(what_would_settle_it(d), HasSubstr("no rest shows"));
  p = confirmed();
  p.ahead = false;
  p.ahead_nats = -40.0;
  EXPECT_THAT(
      what_would_settle_it(with_field(p)),
      HasSubstr("a process of the magnetometer explains the readings better (40 nats ahead"));
}

TEST(Place, finding_says_what_it_takes_and_what_it_predicts) {
  const Finding f = finding_of_place(confirmed(), {});
  EXPECT_EQ(f.effect, "field_departure");
  EXPECT_THAT(f.sentence, AllOf(HasSubstr("85 %"), HasSubstr("5 of 5 blocks"),
                                HasSubstr("420 nats"), HasSubstr("0.4 uT")));
  EXPECT_NEAR(f.gain.heldout_nll_before - f.gain.heldout_nll_after, 420.0, 1e-9);
}

SimulationOptions held(std::uint64_t seed) {
  SimulationOptions o;
  o.motion = SimulatedMotion::kHandHeld;
  o.duration_s = 90.0;
  o.rate_hz = 50.0;
  o.rest_s = 5.0;
  o.seed = seed;
  o.noise = {2e-3, 1.5e-4, 0.05};
  return o;
}

Diagnosis diagnosis_of(const SimulationOptions& o,
                       const std::function<void(Recording&, const SimulationTruth&)>& change) {
  Simulation s = simulate(o);
  change(s.recording, s.truth);
  DiagnosisOptions options;
  options.gravity = o.gravity;
  return diagnose(s.recording, options);
}

bool is_named(const Diagnosis& d) {
  return std::ranges::count(d.findings, "field_departure", &Finding::effect) > 0;
}

TEST(Place, of_a_room_is_named_and_becomes_part_of_the_model) {
  SimulationOptions o = held(3);
  o.room = 3;
  Vector3 bias;
  const Diagnosis d = diagnosis_of(o, [&](Recording&, const SimulationTruth& truth) {
    bias = truth.parameters.mag.front().bias;
  });
  EXPECT_TRUE(is_named(d));
  // Of the field the model knows now what differs from place to place.
  const auto error = [&](const Calibration& c) {
    return (c.parameters.mag.front().bias - bias).norm();
  };
  EXPECT_LT(error(d.after), 0.5 * error(d.before));
  EXPECT_NE(d.answer, Answer::kUnexplained);
  ASSERT_TRUE(d.place);
  EXPECT_GT(d.place->taken_share(), 0.6);
  EXPECT_TRUE(to_json(d)["field_of_place"]["named"]);
}

// The same size and memory, and nothing to do with a place.
class NoPlace : public testing::TestWithParam<bool> {};

TEST_P(NoPlace, is_named_where_the_magnetometer_or_the_field_changes_with_time) {
  const bool in_field = GetParam();
  const Diagnosis d = diagnosis_of(held(5), [&](Recording& r, const SimulationTruth& truth) {
    std::mt19937_64 bits(11);
    std::normal_distribution<double> normal;
    Vector3 b = Vector3::Zero();
    VectorSeries& mag = r.mag.front();
    for (std::size_t k = 0; k < mag.size(); ++k) {
      for (int i = 0; i < 3; ++i) b[i] = std::exp(-0.02) * b[i] + 0.08 * normal(bits);
      mag.v[k] += in_field ? truth.nRb[k].unrotate(b) : b;
    }
  });
  EXPECT_FALSE(is_named(d));
  EXPECT_NE(d.answer, Answer::kPredicts);
}
INSTANTIATE_TEST_SUITE_P(MagnetometerOrField, NoPlace, testing::Bool());

TEST(Place, is_not_named_where_the_accelerometer_is_late) {
  const Diagnosis d = diagnosis_of(held(6), [](Recording& r, const SimulationTruth&) {
    for (double& t : r.acc.t) t += 0.006;
  });
  EXPECT_FALSE(is_named(d));
}

}  // namespace
}  // namespace magimu
