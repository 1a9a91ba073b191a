// SPDX-License-Identifier: BSD-3-Clause
// Another recording of the same device is predicted better by a model that has the effect of the
// device, and not by one that has an effect which is not there.
#include "diagnosis/compare/predict.h"

#include <gmock/gmock.h>

#include "bench/power/hidden_cases.h"
#include "calibration/pipeline.h"

namespace magimu {
namespace {

class Device {
 public:
  explicit Device(const HiddenCase& c)
      : first_(oracle::simulate(c.options).recording),
        second_(oracle::simulate(second_recording(c)).recording),
        motion_(c.moved() ? MotionModel::kHandHeld : MotionModel::kRotation) {
    options_.noise = NoiseDensities{c.options.noise.acc, c.options.noise.gyr, c.options.noise.mag};
  }

  // What an effect gains on the second recording, nats.
  double gain(const std::string& effect) const {
    const std::vector<const Recording*> recordings = {&first_};
    const Pipeline pipeline(recordings, options_);
    const Stage plain = pipeline.with_fixed_symmetries(pipeline.coarse_fit(motion_));
    ModelSpec spec = plain.spec();
    spec.effects = {find_effect(effect)};
    const Stage extended = pipeline.refit(plain, spec);
    const PredictionGain g =
        compare_predictions(second_, extended_model(plain, {}), extended_model(extended, {}));
    EXPECT_FALSE(g.mag_only);
    return g.before - g.after;
  }

 private:
  Recording first_, second_;
  MotionModel motion_;
  CalibrationOptions options_;
};

class TrueEffect : public testing::TestWithParam<const char*> {};

TEST_P(TrueEffect, predicts_the_second_recording_better) {
  EXPECT_GT(Device(draw_case(GetParam(), 2)).gain(GetParam()), 3.0);
}

INSTANTIATE_TEST_SUITE_P(Oracle, TrueEffect,
                         testing::Values("mag_time_offset", "gyro_scale_misalignment",
                                         "gyro_g_sensitivity", "mag_nonlinearity", "field_drift",
                                         "hard_iron_drift", "gyro_bias_drift"),
                         [](const auto& test) { return std::string(test.param); });

// Parameters that are not needed cost about half a nat each, on the average.
TEST(AbsentEffect, does_not_predict_the_second_recording_better) {
  double sum = 0.0;
  int better = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Device device(draw_none(NoiseKind::kWhite, seed));
    for (const char* effect : {"mag_eddy_current", "gyro_g_sensitivity", "field_drift"}) {
      const double gain = device.gain(effect);
      EXPECT_LT(gain, 4.0) << effect << ", seed " << seed;
      sum += gain;
      better += gain > 0.0;
      ++all;
    }
  }
  EXPECT_LT(sum, 0.0);
  EXPECT_LE(better, all / 2);
}

TEST(Predict, a_calibration_of_the_same_model_predicts_as_well_as_itself) {
  const Device device(draw_none(NoiseKind::kWhite, 5));
  EXPECT_LT(std::abs(device.gain("mag_time_offset")), 6.0);
}

// A magnet that is attached at another time of the second recording, or not at all.
TEST(Predict, a_change_is_looked_for_at_its_own_time) {
  HiddenCase c = draw_case("hard_iron_change", 1);
  const Diagnosis d = diagnose(oracle::simulate(c.options).recording, diagnosis_options(c));
  ASSERT_FALSE(d.findings.empty());
  oracle::Options later = second_recording(c);
  const double duration = later.motion.duration_s;
  later.effects[0].parameters[3] = 0.4 * duration;
  later.effects[0].parameters[4] = 0.8 * duration;
  const Recording there = oracle::simulate(later).recording;
  const PredictionGain again = compare_predictions(there, d.model_motion, d.model_after);
  EXPECT_GT(again.before - again.after, 10.0);
  later.effects.clear();
  const Recording gone = oracle::simulate(later).recording;
  const PredictionGain absent = compare_predictions(gone, d.model_motion, d.model_after);
  EXPECT_GT(absent.before - absent.after, -1.0);
}

}  // namespace
}  // namespace magimu
