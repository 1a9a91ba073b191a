// SPDX-License-Identifier: BSD-3-Clause
// Pages of an archive: one for the fleet, one a device with the history of its parameters.
#pragma once

#include <string>
#include <vector>

#include "archive/fleet.h"

namespace magimu::apps {

// page_of: each device's page, relative to the fleet's.
std::string fleet_page(const std::vector<FleetRecording>& rows,
                       const std::vector<FleetDevice>& devices,
                       const std::vector<std::string>& page_of);
std::string device_page(const Device& device, const FleetDevice& summary,
                        const std::vector<const FleetRecording*>& rows);

}  // namespace magimu::apps
