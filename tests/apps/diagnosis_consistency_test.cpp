// SPDX-License-Identifier: BSD-3-Clause
// A diagnosis says one thing: its file, its sentences and the verdict of `magimu calibrate` agree,
// whatever is wrong with a recording.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "apps/say/diagnosis_answer.h"
#include "apps/say/diagnosis_table.h"
#include "calibration/calibrate_whole.h"
#include "diagnosis/result/diagnosis_json.h"
#include "sim/simulate.h"

namespace magimu::apps {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

struct Damage {
  const char* name;
  SimulatedMotion motion;
  std::function<void(Recording&)> to;
};
void PrintTo(const Damage& damage, std::ostream* out) { *out << damage.name; }

void repeat(VectorSeries& s, double begin_s, double end_s) {
  const Vector3* first = nullptr;
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.t[k] < begin_s || s.t[k] > end_s) continue;
    if (first == nullptr) first = &s.v[k];
    s.v[k] = *first;
  }
}

void change(VectorSeries& s, double from_s, const std::function<Vector3(const Vector3&)>& to) {
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.t[k] >= from_s) s.v[k] = to(s.v[k]);
  }
}

const Damage kDamages[] = {
    {"nothing", SimulatedMotion::kHand, [](Recording&) {}},
    {"a_hand_that_moves", SimulatedMotion::kHandHeld, [](Recording&) {}},
    {"a_magnet_from_25_s_on", SimulatedMotion::kHand,
     [](Recording& r) {
       change(r.mag[0], 25.0,
              [](const Vector3& v) -> Vector3 { return v + Vector3(3.0, 0.0, 1.0); });
     }},
    {"a_gyroscope_that_hangs", SimulatedMotion::kHand,
     [](Recording& r) { repeat(r.gyr, 20.0, 22.0); }},
    {"a_gain_of_the_gyroscope", SimulatedMotion::kHand,
     [](Recording& r) {
       change(r.gyr, 25.0,
              [](const Vector3& v) -> Vector3 { return Vector3(1.05 * v[0], v[1], v[2]); });
     }},
    {"a_field_that_swings", SimulatedMotion::kHand,
     [](Recording& r) {
       VectorSeries& mag = r.mag[0];
       for (std::size_t k = 0; k < mag.size(); ++k) mag.v[k][1] += 0.5 * std::sin(0.9 * mag.t[k]);
     }},
    {"an_accelerometer_whose_bias_jumps", SimulatedMotion::kHandHeld,
     [](Recording& r) {
       change(r.acc, 25.0, [](const Vector3& v) -> Vector3 { return v + Vector3(0.5, 0.0, 0.0); });
     }},
    {"a_rest", SimulatedMotion::kHand,
     [](Recording& r) {
       for (VectorSeries* s : {&r.acc, &r.gyr, &r.mag[0]}) {
         for (std::size_t k = 100; k < s->size(); ++k) s->v[k] = s->v[k % 100];
       }
     }},
};

class DiagnosisOf : public testing::TestWithParam<Damage> {
 protected:
  static Recording recording() {
    SimulationOptions o;
    o.motion = GetParam().motion;
    o.rate_hz = 50.0;
    o.duration_s = 50.0;
    o.seed = 4511;
    Recording r = simulate(o).recording;
    r.name = "rec.csv";
    GetParam().to(r);
    return r;
  }
};

// The verdict is calibrate()'s, and so are its reasons.
void expect_the_verdict_of(const Calibration& c, const Diagnosis& d, const std::string& text) {
  EXPECT_EQ(d.before.trust.verdict, c.trust.verdict);
  EXPECT_EQ(d.before.trust.reasons, c.trust.reasons);
  EXPECT_THAT(text, HasSubstr("as `magimu calibrate` judges it: " + to_string(c.trust.verdict)));
  const auto file = to_json(d);
  EXPECT_EQ(file["calibration_before"]["trust"]["verdict"], to_string(c.trust.verdict));
  if (c.trust.verdict == Verdict::kNo) {
    EXPECT_NE(d.answer, Answer::kPredicts);
  }
}

void expect_fields_that_agree_with_the_answer(const Diagnosis& d) {
  const bool left = d.answer == Answer::kPartly || d.answer == Answer::kUnexplained;
  EXPECT_EQ(d.unexplained.detected, left);
  EXPECT_EQ(d.unexplained.evidence.empty(), !left);
  EXPECT_EQ(d.next_step.empty(), !left);
  if (!left) {
    EXPECT_THAT(d.unexplained.channels, IsEmpty());
  }
  for (const std::string& sentence : d.unexplained.evidence) {
    EXPECT_THAT(d.evidence, Contains(sentence));
  }
  if (d.answer == Answer::kNone) {
    EXPECT_THAT(d.evidence, Not(IsEmpty()));
  }
  if (d.answer == Answer::kPartly) {
    EXPECT_THAT(d.findings, Not(IsEmpty()));
  }
  if (d.answer == Answer::kPredicts) {
    EXPECT_THAT(d.findings, IsEmpty());
    EXPECT_THAT(d.departures_after, IsEmpty());
  }
  if (d.answer == Answer::kExplained && d.findings.empty()) {
    EXPECT_THAT(d.after.set_aside, Not(IsEmpty()));
  }
  for (const ActiveEffect& effect : d.after.effects) {
    EXPECT_THAT(d.findings, Contains(testing::Field(&Finding::effect, effect.name)));
  }
}

void expect_a_headline_that_agrees(const Diagnosis& d) {
  const std::string said = headline(d);
  EXPECT_EQ(said.find("something is left") != std::string::npos, d.answer == Answer::kPartly);
  EXPECT_EQ(said.find("does not predict") != std::string::npos, d.answer == Answer::kUnexplained);
  EXPECT_EQ(said == "The simulation predicts these data.", d.answer == Answer::kPredicts);
  EXPECT_EQ(said.find("do not permit") != std::string::npos, d.answer == Answer::kNone);
  const bool named = said.starts_with("The simulation gets ");
  EXPECT_EQ(named,
            (d.answer == Answer::kPartly || d.answer == Answer::kExplained) && !d.findings.empty());
}

TEST_P(DiagnosisOf, agrees_with_itself_and_with_the_calibration) {
  const Recording r = recording();
  DiagnosisOptions options;
  options.gravity = kPaperGravity;
  CalibrationOptions calibration;
  calibration.gravity = options.gravity;
  const Diagnosis d = diagnose(r, options);
  SCOPED_TRACE(to_string(d.answer) + "\n" + diagnosis_table(d));
  // (What calibrate() says since a magnet was attached is of other samples.)
  expect_the_verdict_of(calibrate_whole({&r}, calibration), d, diagnosis_table(d));
  expect_fields_that_agree_with_the_answer(d);
  expect_a_headline_that_agrees(d);
}

INSTANTIATE_TEST_SUITE_P(Damaged, DiagnosisOf, testing::ValuesIn(kDamages),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace magimu::apps
