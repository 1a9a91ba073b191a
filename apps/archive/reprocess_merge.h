// SPDX-License-Identifier: BSD-3-Clause
// From results to devices, tables and pages. Devices are read one after the other, so that memory
// holds the summaries of one device only.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "archive/fleet.h"

namespace magimu::apps {

// Recordings of one device that have a calibration, and their rows; the other rows get their
// reason.
std::vector<DeviceRecording> recordings_of(const std::vector<FleetRecording*>& rows,
                                           const std::string& folder,
                                           std::vector<FleetRecording*>& calibrated);

// rows: path, device, place, date and result (or status and reason) are filled in. Writes
// devices/NAME.json and .html, recordings.csv, devices.csv, changes.csv, archive.sqlite and
// index.html in the folder; removes files of devices that are there no more. devices_by: how
// devices were told, for the page. Nothing: it was asked to stop before the end.
std::optional<std::vector<FleetDevice>> merge_archive(std::vector<FleetRecording>& rows,
                                                      const std::string& folder,
                                                      const std::string& devices_by, bool quiet);

}  // namespace magimu::apps
