// SPDX-License-Identifier: BSD-3-Clause
#include "archive/second_pass.h"

#include <algorithm>
#include <utility>

namespace magimu {

bool none_tells_enough(const std::vector<DeviceRecording>& recordings) {
  const auto fits = std::ranges::count_if(
      recordings, [](const DeviceRecording& r) { return r.condensed.has_value(); });
  return fits > 1 && std::ranges::all_of(recordings, [](const DeviceRecording& r) {
           return !r.condensed || r.calibration.trust.verdict == Verdict::kNo;
         });
}

void take_second_pass(DeviceRecording& recording, DeviceRecording second) {
  if (!second.condensed) return;
  recording.condensed = std::move(second.condensed);
  recording.widened = second.widened;
  recording.at_device = std::move(second.calibration);
}

}  // namespace magimu
