// SPDX-License-Identifier: BSD-3-Clause
// Simulated devices of an archive: each with recordings of its own motions, and what an archive
// makes of them compared with the truth.
#pragma once

#include <string>

#include "archive/device.h"
#include "sim/device_recording.h"

namespace magimu {

struct ArchiveMade {
  int devices = 40, recordings = 25;
  double seconds = 60.0;     // of a recording; few: none tells all by itself
  bool given_noise = false;  // the true densities are given instead of estimated from each
};
// The k-th recording of a device: hand motion, 40 Hz, a dip of its own.
Simulation archive_recording(const SensorParameters& device, std::uint64_t seed, double seconds);

struct NeesReport {
  std::vector<double> nees;  // a device, over 19
  // For each group of parameters: its name, and each device's NEES of the group over its size.
  std::vector<std::pair<std::string, std::vector<double>>> groups;
  std::size_t flagged = 0;  // devices with a change, where there is none
  double calibrate_s = 0.0, condensed_s = 0.0;
  std::string text() const;
};
// NEES of the devices' parameters and last dip by the covariance in the device's file.
NeesReport device_nees(const ArchiveMade& archive);

// Devices' estimates from summaries against a calibration of all their samples together. For each
// device the largest difference of a parameter, in its standard deviations (the model's).
std::vector<double> distances_from_together(const ArchiveMade& archive);

struct ChangesReport {
  int devices = 0, changed = 0, dated = 0, named_step = 0, false_alarms = 0;
};
// By summaries alone: half of the devices have a change of that size (sigmas of one recording) in
// the middle three quarters of their history, or none. drift: of D's scale, steady, its whole size.
ChangesReport device_changes(int devices, int recordings, double sigmas, bool drift);

}  // namespace magimu
