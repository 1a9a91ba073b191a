// SPDX-License-Identifier: BSD-3-Clause
// Recordings and options that permit no fit end with the verdict `no` and a reason that is right,
// in a file that can be read; never with an exception.
#include <gmock/gmock.h>

#include "calibration/live/streaming.h"
#include "calibration/pipeline.h"
#include "calibration/result/calibration_json.h"
#include "calibration/trust/no_fit.h"
#include "graph/numerical_error.h"
#include "recording/data/error.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::Not;

Simulation short_case() {
  static const Simulation simulation = test::simulated_hand(50.0, 3, 20.0);
  return simulation;
}

// As the file is read; throws where it would be refused.
Calibration read_back(const Calibration& c) {
  const auto json = nlohmann::ordered_json::parse(to_json(c).dump());
  return calibration_from_json(json, "file");
}

void expect_an_honest_no(const Calibration& c) {
  EXPECT_EQ(c.trust.verdict, Verdict::kNo);
  ASSERT_FALSE(c.trust.reasons.empty());
  EXPECT_THAT(c.trust.reasons, Each(Not(HasSubstr("nan"))));
  EXPECT_THAT(to_json(c).dump(), Not(HasSubstr("null"))) << "a number that is not finite";
  const Calibration read = read_back(c);
  EXPECT_EQ(read.trust.verdict, Verdict::kNo);
  EXPECT_GT(read.parameters.mag.front().distortion.determinant(), 0.0);
}

TEST(NoFit, a_density_beyond_double_arithmetic_ends_and_is_named) {
  const Simulation s = short_case();
  for (const NoiseDensities noise :
       {NoiseDensities{0.02, 8.7e-4, 1e-20}, NoiseDensities{0.02, 1e-30, 0.1},
        NoiseDensities{1e-160, 8.7e-4, 0.1}}) {
    CalibrationOptions options;
    options.noise = noise;
    const Calibration c = calibrate(s.recording, options);
    EXPECT_NE(c.trust.verdict, Verdict::kYes);
    EXPECT_THAT(c.trust.reasons, testing::Contains(HasSubstr("The noise density given for the")));
    EXPECT_NO_THROW(read_back(c));
  }
}

TEST(NoFit, densities_of_the_right_size_are_not_spoken_of) {
  const Simulation s = short_case();
  for (const double times : {0.3, 1.0, 3.0}) {
    CalibrationOptions options;
    options.noise = {times * s.truth.noise.acc, times * s.truth.noise.gyr,
                     times * s.truth.noise.mag};
    const Calibration c = calibrate(s.recording, options);
    EXPECT_THAT(c.trust.reasons, Each(Not(HasSubstr("noise density given")))) << times;
  }
}

TEST(NoFit, a_density_a_hundred_times_off_is_told) {
  const Simulation s = short_case();
  for (const double times : {0.01, 100.0}) {
    CalibrationOptions options;
    options.motion = MotionModel::kRotation;
    options.noise = s.truth.noise;
    options.noise->mag *= times;
    EXPECT_THAT(calibrate(s.recording, options).trust.reasons,
                testing::Contains(HasSubstr("The noise density given for the magnetometer")))
        << times;
  }
}

// Fits with noise that no factor can have, and with a reading whose square is not finite.
TEST(NoFit, a_stage_names_sensor_and_time) {
  const Simulation s = short_case();
  Recording damaged = s.recording;
  damaged.acc.v[500][2] = 1e160;
  for (const MotionModel motion : {MotionModel::kRotation, MotionModel::kHandHeld}) {
    CalibrationOptions options;
    options.motion = motion;
    const std::vector<const Recording*> good = {&s.recording}, bad = {&damaged};
    const Pipeline pipeline(good, options);
    const Stage fitted = pipeline.coarse_fit(motion);
    ModelSpec spec = fitted.spec();
    spec.noise.gyr = 0.0;
    EXPECT_THAT([&] { (void)pipeline.refit_with_same_noise(fitted, spec); },
                testing::ThrowsMessage<NumericalError>(
                    testing::AllOf(HasSubstr("gyroscope"), HasSubstr(" s of "))));
    EXPECT_THAT([&] { (void)Pipeline(bad, options).coarse_fit(motion); },
                testing::ThrowsMessage<NumericalError>(HasSubstr(" s of simulation")));
  }
}

TEST(NoFit, claims_nothing) {
  const Simulation s = short_case();
  const Calibration c = calibration_without_fit({&s.recording}, {}, "x3 is not a finite number",
                                                {"rec.csv: a gap of 3 s."});
  expect_an_honest_no(c);
  EXPECT_THAT(c.trust.reasons,
              testing::ElementsAre("No fit could be made: x3 is not a finite number.",
                                   "rec.csv: a gap of 3 s."));
  EXPECT_GT(c.sigma("field.dip_deg"), 45.0);
  EXPECT_GT(c.sigma("magnetometers[0].bias[0]"), 20.0);
}

// Finite, but its square is not.
TEST(NoFit, readings_that_are_far_too_large_end_with_a_reason) {
  for (const double size : {1e20, 1e160}) {
    for (const int sensor : {0, 1, 2}) {
      Recording recording = short_case().recording;
      VectorSeries& series = sensor == 0   ? recording.acc
                             : sensor == 1 ? recording.gyr
                                           : recording.mag.front();
      series.v[300][1] = size;
      try {
        const Calibration c = calibrate(recording);
        EXPECT_NO_THROW(read_back(c)) << size << ", sensor " << sensor;
      } catch (const InputError&) {  // refused before
      }
    }
  }
}

TEST(NoFit, a_stream_goes_on_after_a_reading_that_is_far_too_large) {
  const Simulation s = test::simulated_hand(50.0, 3, 40.0);
  StreamingCalibration stream(1, {});
  const Recording& r = s.recording;
  for (std::size_t k = 0; k < r.gyr.size(); ++k) {
    StreamSample sample;
    sample.t = r.gyr.t[k];
    sample.gyr = r.gyr.v[k];
    sample.acc = k == 1500 ? Vector3(1e160, 0.0, 0.0) : r.acc.v[k];
    sample.mag = {r.mag.front().v[k]};
    stream.add(sample);
  }
  const Calibration c = stream.finish();
  EXPECT_FALSE(c.order.empty());
  EXPECT_NO_THROW(read_back(c));
}

}  // namespace
}  // namespace magimu
