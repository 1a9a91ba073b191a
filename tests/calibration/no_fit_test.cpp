// SPDX-License-Identifier: BSD-3-Clause
// Recordings and options that permit no fit end with the verdict `no` and a reason that is right,
// in a file that can be read; never with an exception.
#include <gmock/gmock.h>

#include "calibration/calibration_json.h"
#include "calibration/streaming.h"
#include "calibration/survey.h"
#include "recording/error.h"
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

// Two nodes at times that doubles hardly tell apart: no time passes in which noise could gather.
TEST(NoFit, samples_between_which_no_time_passes_are_named) {
  Recording recording = short_case().recording;
  VectorSeries& mag = recording.mag.front();
  VectorSeries crowded;
  for (std::size_t k = 0; k < mag.size(); ++k) {
    crowded.push_back(mag.t[k], mag.v[k]);
    if (k == 500) crowded.push_back(mag.t[k] + 1e-13, 1.0001 * mag.v[k]);
  }
  mag = crowded;
  const Calibration c = calibrate(recording);
  if (c.fit.values.size() > 0) GTEST_SKIP() << "such samples are taken care of before";
  expect_an_honest_no(c);
  EXPECT_THAT(c.trust.reasons.front(), HasSubstr("10.0"));
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
        (void)survey(recording);
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
