// SPDX-License-Identifier: BSD-3-Clause
// What every command that reads recordings takes to understand a file that is not written our way:
// names of columns, units, axes; and the reading itself, which prints what it did.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "recording/csv/csv.h"

namespace magimu::apps {

struct ReadingOptions {
  std::vector<std::string> map;   // OURS=THEIRS
  std::vector<std::string> unit;  // SENSOR=UNIT
  std::vector<std::string> axes;  // SENSOR=A,B,C
  std::string gyro_interval = "forward";
  double rate_hz = 0.0;  // 0: the file has times
  std::string columns;   // the header that a file lacks
  std::vector<std::string> sensors;

  // Options for readers. Throws InputError if one of `map` or `unit` cannot be understood.
  CsvOptions csv() const;
  // From `axes`: sensors, and the matrices that multiply their readings (recording/data/axes.h).
  std::vector<std::pair<std::string, Matrix3>> turns() const;
};

// An option that may be given several times takes one word each time, not what stands behind it.
CLI::Option* repeatable(CLI::Option* option);
// Adds --map, --unit, --axes, --rate, --columns, --gyro-interval and --sensor. `options` must
// outlive `cmd`.
void add_column_options(CLI::App& cmd, ReadingOptions& options);
void add_reading_options(CLI::App& cmd, ReadingOptions& options);

// The recording, its axes and gyroscope interval as the library has them; what the reader noticed
// goes to standard error unless quiet.
Recording read_with(const std::string& path, const ReadingOptions& options, bool quiet);
// The same of several paths; files that are parts of one recording are joined (recording/read.h).
std::vector<Recording> read_all_with(const std::vector<std::string>& paths,
                                     const ReadingOptions& options, bool quiet);

}  // namespace magimu::apps
