// SPDX-License-Identifier: BSD-3-Clause
// Which device a recording is of, where nobody has said so: the ways in which the paths of an
// archive can be read. Names alone cannot decide between drone1/log1.csv (a folder a device) and
// session1/board1.csv (a folder a session); the first reading is the more usual one, and the
// recordings' calibrations decide against it where they are clear (same_device.h).
#pragma once

#include <string>
#include <vector>

namespace magimu {

struct DeviceReading {
  std::string rule;                 // "each folder is a device"
  std::vector<std::string> device;  // the device's name, for each path
};

// shown: paths relative to the archive; archive: its own name, for files that have none.
// At least one reading, no two with the same groups, the most usual first.
std::vector<DeviceReading> device_readings(const std::vector<std::string>& shown,
                                           const std::string& archive);

// Do two readings make the same groups, whatever they call them?
bool same_groups(const std::vector<std::string>& a, const std::vector<std::string>& b);

}  // namespace magimu
