// SPDX-License-Identifier: BSD-3-Clause
// What an archive consists of: a table of recordings, or a folder that is searched for them.
//
//   path,device,place,date,options
//   2024/a/imu.csv,board-7,lab,2024-05-03,--unit gyr=deg/s
//
// Columns but `path` may be left out, and come in any order; fields with commas are quoted as
// usual ("..."; a quote within is doubled). Paths are relative to the manifest.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "archive/inventory/device_readings.h"

namespace magimu {

struct ManifestEntry {
  std::string path;             // as it can be opened
  std::string shown;            // relative to the manifest or folder: names it in tables
  std::string device;           // what shares parameters
  bool device_guessed = false;  // from names: see device_readings_of()
  std::string place;            // recordings at one place share the field's strength
  // ISO 8601; the order of the history: as given, else as names have it (date_in_path()). Empty:
  // the order of `shown`.
  std::string date;
  std::string options;  // of magimu calibrate, for this recording
  bool unreadable_row = false;
  std::string problem;  // of the row itself
};

// InputError, naming line and column, where the table cannot be understood as a whole.
std::vector<ManifestEntry> read_manifest(const std::string& path);
// Every file below the folder (files_below()) in the order of names.
std::vector<ManifestEntry> manifest_of_folder(const std::string& path);
// Whichever of the two the path is.
std::vector<ManifestEntry> manifest_of(const std::string& path);

// The ways in which devices can be told from the entries' names, the most usual first: entries
// whose device is guessed have the first one's.
std::vector<DeviceReading> device_readings_of(const std::vector<ManifestEntry>& entries,
                                              const std::string& path);

// Words of an options field, by blanks; "..." and '...' keep blanks. nullopt: a quote is open.
std::optional<std::vector<std::string>> split_words(const std::string& text);

// Days since 1970-01-01 of "2024-05-03", "2024-05-03T14:07", "2024-05-03 14:07:30[.5][Z]".
std::optional<double> days_of(const std::string& date);

}  // namespace magimu
