// SPDX-License-Identifier: BSD-3-Clause
#include "archive/second_pass.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "calibration/condensed_recording.h"
#include "sim/device_recording.h"

namespace magimu {
namespace {

CalibrationOptions given_noise() {
  CalibrationOptions options;
  options.noise = kPaperNoise;
  options.gravity = kPaperGravity;
  options.motion = MotionModel::kRotation;
  return options;
}

constexpr std::uint64_t kDevice = 50301, kOther = 50302;

Recording turned_by_hand(std::uint64_t device, std::uint64_t seed, double rate_hz, double seconds) {
  SimulationOptions sim;
  sim.motion = SimulatedMotion::kHand;
  sim.seed = seed;
  sim.rate_hz = rate_hz;
  sim.duration_s = seconds;
  return simulate_device(sim, draw_parameters(device, 1)).recording;
}

// Six recordings of one device: six seconds each, of which two at rest, a turn or less.
const std::vector<Recording>& short_recordings() {
  static const std::vector<Recording> all = [] {
    std::vector<Recording> out;
    for (std::uint64_t seed = 50311; seed < 50317; ++seed) {
      out.push_back(turned_by_hand(kDevice, seed, 50.0, 6.0));
      out.back().name = "r" + std::to_string(seed);
    }
    return out;
  }();
  return all;
}

Calibration together(PriorKind prior) {
  std::vector<const Recording*> all;
  for (const Recording& r : short_recordings()) all.push_back(&r);
  CalibrationOptions options = given_noise();
  options.prior = prior;
  return calibrate(all, options);
}

DeviceRecording by_itself(const Recording& recording) {
  DeviceRecording out;
  out.name = out.shown = recording.name;
  out.calibration = calibrate_condensed(recording, given_noise(), out.condensed);
  return out;
}

DeviceRecording at(const Calibration& device, const Recording& recording) {
  DeviceRecording out;
  out.calibration = calibrate_condensed_at(device, recording, given_noise(), out.condensed);
  return out;
}

double value_of(const Device& device, const std::string& name) {
  return device.joint[std::ranges::find(device.order, name) - device.order.begin()];
}

TEST(SecondPass, recordings_that_tell_too_little_one_by_one_say_together_what_their_samples_do) {
  const Calibration start = together(PriorKind::kUsual), all = together(PriorKind::kNone);
  std::vector<DeviceRecording> recordings;
  for (const Recording& r : short_recordings()) {
    recordings.push_back(by_itself(r));
    EXPECT_EQ(recordings.back().calibration.trust.verdict, Verdict::kNo) << r.name;
  }
  EXPECT_TRUE(none_tells_enough(recordings));
  EXPECT_EQ(make_device("d", recordings).calibration, std::nullopt);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    take_second_pass(recordings[i], at(start, short_recordings()[i]));
  }
  const Device device = make_device("d", recordings);
  EXPECT_EQ(device.used.size(), recordings.size());
  ASSERT_TRUE(device.calibration);
  EXPECT_EQ(device.calibration->trust.verdict, Verdict::kLimited)
      << device.calibration->trust.reasons.front();
  for (int i = 0; i < 3; ++i) {
    const std::string axis = "[" + std::to_string(i) + "]";
    const std::string hard_iron = "magnetometers[0].bias" + axis, bias = "gyroscope.bias" + axis;
    EXPECT_NEAR(value_of(device, hard_iron), all.parameters.mag[0].bias[i],
                0.01 * all.sigma_model(hard_iron));
    EXPECT_NEAR(value_of(device, bias), all.parameters.gyr_bias[i], 0.01 * all.sigma_model(bias));
    for (int j = 0; j < 3; ++j) {
      const std::string name = "magnetometers[0].distortion" + axis + "[" + std::to_string(j) + "]";
      EXPECT_NEAR(value_of(device, name), all.parameters.mag[0].distortion(i, j),
                  0.01 * all.sigma_model(name));
    }
  }
}

TEST(SecondPass, what_is_of_another_device_is_not_used) {
  const Recording stranger = turned_by_hand(kOther, 50318, 50.0, 6.0);
  DeviceRecording own = by_itself(stranger);
  own.name = own.shown = "stranger";
  take_second_pass(own, at(together(PriorKind::kUsual), stranger));
  ASSERT_TRUE(own.at_device);
  EXPECT_EQ(own.at_device->trust.verdict, Verdict::kNo);
  EXPECT_TRUE(make_device("d", {own}).used.empty());
}

TEST(SecondPass, is_for_devices_of_which_no_recording_tells_enough) {
  const DeviceRecording rich = by_itself(turned_by_hand(kDevice, 50319, 20.0, 60.0));
  const DeviceRecording poor = by_itself(short_recordings()[0]);
  EXPECT_FALSE(none_tells_enough({poor, rich}));
  EXPECT_FALSE(none_tells_enough({poor}));
  EXPECT_TRUE(none_tells_enough({poor, poor}));
}

}  // namespace
}  // namespace magimu
