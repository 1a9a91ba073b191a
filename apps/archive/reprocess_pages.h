// SPDX-License-Identifier: BSD-3-Clause
// Pages of an archive: one for the fleet, one a device with the history of its parameters.
#pragma once

#include <string>
#include <vector>

#include "archive/fleet.h"

namespace magimu::apps {

// page_of: each device's page, relative to the fleet's. devices_by: how devices were told, empty:
// somebody has said it.
std::string fleet_page(const std::vector<FleetRecording>& rows,
                       const std::vector<FleetDevice>& devices,
                       const std::vector<std::string>& page_of, const std::string& devices_by);
std::string device_page(const Device& device, const FleetDevice& summary,
                        const std::vector<const FleetRecording*>& rows);

}  // namespace magimu::apps
