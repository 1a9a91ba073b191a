// SPDX-License-Identifier: BSD-3-Clause
#include "archive/second_pass.h"

#include <algorithm>

namespace magimu {

bool is_no_by_itself(const DeviceRecording& r) {
  return r.condensed && r.calibration.trust.verdict == Verdict::kNo;
}

std::optional<Calibration> device_by_the_others(const std::string& name,
                                                const std::vector<DeviceRecording>& recordings) {
  std::vector<DeviceRecording> rich;
  std::ranges::copy_if(recordings, std::back_inserter(rich),
                       [](const DeviceRecording& r) { return !is_no_by_itself(r); });
  Device device = make_device(name, std::move(rich));
  if (!device.calibration || device.turns) return std::nullopt;
  if (device.calibration->trust.verdict == Verdict::kNo) return std::nullopt;
  return std::move(device.calibration);
}

void take_second_pass(DeviceRecording& recording, DeviceRecording second) {
  if (!second.condensed) return;
  recording.condensed = std::move(second.condensed);
  recording.widened = second.widened;
  recording.at_device = std::move(second.calibration);
}

}  // namespace magimu
