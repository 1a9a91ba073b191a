// SPDX-License-Identifier: BSD-3-Clause
// An archive as tables: one row a recording, one a device, one a change; as CSV and as one SQLite
// file. docs/reprocess.md names the columns.
#pragma once

#include "archive/device.h"

namespace magimu {

// One line of the manifest and what became of it.
struct FleetRecording {
  std::string path, device, place, date;
  std::string result;     // the result's name; empty: none
  std::string at_device;  // path of the result with the device's parameters held; empty: none
  std::string status;     // of result_file.h, or "missing", "duplicate", "unfinished"
  std::string reason, remedy;
  std::string found;  // options that the program found
  double duration_s = 0.0;
  // Of those with a calibration.
  bool calibrated = false;
  std::string own_verdict, verdict, agrees_with, motion;
  bool used = false;
  double distance = 0.0;
  double strength_uT = 0.0, strength_sigma_uT = 0.0, dip_deg = 0.0;
  Vector3 hard_iron = Vector3::Zero(), hard_iron_sigma = Vector3::Zero();
};

struct FleetChange {
  std::string kind, what, recording, date, sentence;
  double probability = 0.0, date_probability = 0.0, log_bayes_factor = 0.0;
  bool clear = true;  // is_clear()
  ChangeSize size;
};

struct FleetParameter {
  std::string recording;  // at whose time; empty: now
  std::string name;
  double value = 0.0, sigma = 0.0;
};

struct FleetDevice {
  std::string name, verdict, reason;
  std::size_t recordings = 0, calibrated = 0, used = 0;
  double birge = 1.0, strength_uT = 0.0, strength_sigma_uT = 0.0;
  std::vector<FleetChange> changes;
  std::vector<FleetParameter> parameters;
};

// Rows of the device's recordings are completed: verdict, agreement, parameters.
FleetDevice fleet_device(const Device& device, std::vector<FleetRecording*> rows);

std::string recordings_csv(const std::vector<FleetRecording>& rows);
std::string devices_csv(const std::vector<FleetDevice>& devices);
std::string changes_csv(const std::vector<FleetDevice>& devices);
// The bytes of an SQLite database with the tables recordings, devices, changes and parameters.
std::string fleet_database(const std::vector<FleetRecording>& rows,
                           const std::vector<FleetDevice>& devices);

// The device's calibration file, with "device", "recordings", "changes" and "history" in it.
std::string device_json(const Device& device);

}  // namespace magimu
