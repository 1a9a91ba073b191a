// SPDX-License-Identifier: BSD-3-Clause
// Recordings that a program puts together in memory, and what may be wrong with them, at every
// function that takes one.
#include <gmock/gmock.h>

#include <cmath>

#include "calibration/live/streaming.h"
#include "calibration/rivals/rival_calibration.h"
#include "calibration/survey/survey.h"
#include "calibration/use/apply.h"
#include "recording/data/error.h"
#include "tests/calibration/cases.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Recording minute() {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 50.0;
  options.duration_s = 60.0;
  return simulate(options).recording;
}

TEST(RecordingsByHand, need_no_names_of_magnetometers) {
  const Recording named = minute();
  Recording bare = named;
  bare.mag_names.clear();
  const Calibration expected = calibrate(named), c = calibrate(bare);
  EXPECT_THAT(c.mag_names, ElementsAre("mag"));
  EXPECT_EQ(c.parameters.mag[0].bias, expected.parameters.mag[0].bias);
  const Survey s = survey(bare);
  ASSERT_EQ(s.sensors.size(), 3u);
  EXPECT_EQ(s.sensors[2].name, "mag");
  EXPECT_EQ(apply(c, bare).recording.mag[0].v, apply(c, named).recording.mag[0].v);
}

TEST(RecordingsByHand, are_refused_everywhere_where_times_and_values_differ_in_number) {
  const Recording r = minute();
  const Calibration c = calibrate(r);
  for (const auto& spoil : std::vector<std::function<void(Recording&)>>{
           [](Recording& q) { q.gyr.v.resize(2000); }, [](Recording& q) { q.mag[0].v.pop_back(); },
           [](Recording& q) { q.acc.t.pop_back(); }}) {
    Recording q = r;
    spoil(q);
    for (const auto& use : std::vector<std::function<void()>>{
             [&] { calibrate(q); },
             [&] {
               calibrate({&r, &q});
             },
             [&] { survey(q); }, [&] { apply(c, q); }, [&] { calibrate_by({}, {&q}, {}); }}) {
      EXPECT_THAT(test::error_of(use).what(), HasSubstr(" times and "));
    }
  }
}

TEST(RecordingsByHand, need_samples_of_every_sensor) {
  Recording q = minute();
  q.mag.push_back({});
  q.mag_names = {"mag1", "mag2"};
  EXPECT_THAT(test::error_of([&] { calibrate(q); }).what(),
              HasSubstr("there are no mag2 samples; record them as well"));
  q = minute();
  q.gyr = {};
  EXPECT_THAT(test::error_of([&] { calibrate(q); }).what(),
              HasSubstr("there are no gyroscope samples"));
  EXPECT_THAT(survey(q).not_looked_further, HasSubstr("there are no gyroscope samples"));
  EXPECT_THAT(test::error_of([&] { calibrate(Recording()); }).what(),
              HasSubstr("there are no magnetometer samples"));
}

TEST(RecordingsByHand, need_times_that_are_numbers) {
  Recording q = minute();
  q.mag[0].t[100] = NAN;
  for (const auto& use :
       std::vector<std::function<void()>>{[&] { calibrate(q); }, [&] { survey(q); }}) {
    EXPECT_THAT(test::error_of(use).what(), HasSubstr("the time of sample 100 of mag is nan"));
  }
  StreamingCalibration stream(1);
  StreamSample sample;
  sample.t = NAN;
  sample.mag.resize(1);
  EXPECT_THAT(test::error_of([&] { stream.add(sample); }).what(),
              HasSubstr("the time of a sample is nan"));
}

TEST(RecordingsByHand, a_stream_has_magnetometers) {
  for (const int n : {0, -1}) {
    EXPECT_THAT(test::error_of([n] { StreamingCalibration stream(n); }).what(),
                HasSubstr("it has " + std::to_string(n) + " magnetometers"));
  }
}

}  // namespace
}  // namespace magimu
