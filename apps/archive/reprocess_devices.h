// SPDX-License-Identifier: BSD-3-Clause
// Which device each recording of an archive is of, where the archive does not say so: the usual
// reading of the names, unless the recordings' calibrations fit another one far better.
#pragma once

#include <string>
#include <vector>

#include "archive/fleet.h"
#include "archive/inventory/manifest.h"

namespace magimu::apps {

// rows: one an entry; those whose device is guessed get it. folder: where results are. Says which
// rule was used; empty where nothing was guessed.
std::string choose_devices(const std::vector<ManifestEntry>& entries,
                           const std::vector<DeviceReading>& readings, const std::string& folder,
                           std::vector<FleetRecording>& rows);

}  // namespace magimu::apps
