// SPDX-License-Identifier: BSD-3-Clause
// A recording as a logger has it just before its lines are written: rows of samples, and beside
// them whatever else may come to stand in such a file (a token that is no number, half a line, a
// header in the middle). Faults work on it; what reads it is the program alone.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

struct LogRow {
  double t = 0.0;
  std::vector<Vector3> v;             // one a sensor, whether it has a sample or not
  unsigned has = 0;                   // bit i: sensor i has a sample at this time
  std::string time_token;             // not empty: written in place of t
  std::map<int, std::string> tokens;  // in place of the number of field 3 sensor + axis
  std::string line;                   // not empty: the whole line, in place of all fields

  bool has_sensor(int sensor) const { return (has >> sensor & 1u) != 0; }
};

constexpr int kAllDigits = -1;

struct Log {
  std::vector<std::string> names;  // of the sensors: "acc", "gyr", "mag" or "mag1", "mag2", ...
  std::vector<LogRow> rows;
  // Decimals of each sensor's numbers and of the time; kAllDigits: the shortest text that reads
  // back as the same number.
  std::vector<int> digits;
  int time_digits = kAllDigits;
  std::string time_name = "t";

  int sensors() const { return int(names.size()); }
  // Rows in which the sensor has a sample.
  std::vector<std::size_t> rows_of(int sensor) const;
};

// Samples of one time share a row.
Log log_of(const Recording& recording);

// One number as the log's file has it.
std::string field_text(const Log& log, int sensor, double value);
// One row, without the end of the line.
std::string row_text(const Log& log, const LogRow& row);
// The header, likewise.
std::string header_text(const Log& log);
// The whole file.
std::string file_text(const Log& log);

}  // namespace magimu
