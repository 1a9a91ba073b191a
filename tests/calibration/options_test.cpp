// SPDX-License-Identifier: BSD-3-Clause
// Options that no data could make up for are refused before anything is computed.
#include <gmock/gmock.h>

#include <cmath>

#include "calibration/calibrate.h"
#include "calibration/live/streaming.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

void expect_refused(const CalibrationOptions& options, const std::string& name) {
  EXPECT_THAT([&] { calibrate(Recording(), options); },
              ThrowsMessage<std::invalid_argument>(HasSubstr(name)));
}

TEST(CalibrationOptions, what_means_nothing_is_refused_by_name) {
  for (const double density : {0.0, -1.0, std::nan("")}) {
    for (double NoiseDensities::*sensor :
         {&NoiseDensities::acc, &NoiseDensities::gyr, &NoiseDensities::mag}) {
      CalibrationOptions options;
      options.noise = NoiseDensities();
      options.noise->acc = options.noise->gyr = options.noise->mag = 0.01;
      (*options.noise).*sensor = density;
      expect_refused(options, "noise densities");
    }
  }
  CalibrationOptions options;
  options.gravity = std::nan("");
  expect_refused(options, "gravity");
  options = {};
  options.block_s = 0.0;
  expect_refused(options, "block_s");
  options = {};
  options.node_every = -3;
  expect_refused(options, "node_every");
}

TEST(StreamingOptions, a_window_has_a_length) {
  StreamingOptions options;
  options.window_s = 0.0;
  EXPECT_THAT([&] { StreamingCalibration(1, options); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("window_s")));
}

// The natural way to say that a slower magnetometer has no reading.
TEST(StreamingCalibration, a_sample_without_entries_for_its_magnetometers_says_what_to_give) {
  StreamingCalibration stream(1);
  StreamSample sample;
  sample.t = 1.0;
  sample.acc = Vector3(0.0, 0.0, 9.8);
  sample.gyr = Vector3::Zero();
  EXPECT_THAT([&] { stream.add(sample); }, ThrowsMessage<InputError>(HasSubstr("std::nullopt")));
}

}  // namespace
}  // namespace magimu
