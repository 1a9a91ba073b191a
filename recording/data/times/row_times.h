// SPDX-License-Identifier: BSD-3-Clause
// The times of a file's rows in seconds, from what its time column holds: in whatever unit, since
// 1970 or since boot, counted by a counter that rolls over, set back by a reset, stamped on
// arrival. What is ambiguous is refused; what is changed is said.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace magimu {

// Seconds between the last sample before a clock was set, and the first one after it, which nobody
// knows: longer than any gap that is bridged (parts.h).
constexpr double kPartGap = 10.0;

struct RowTimesOptions {
  double unit = 1.0;              // of the time column, s, where it is known
  bool unit_known = false;        // by option or by its header; else it is to be recognised
  std::string unit_in_header;     // what the header calls it; empty: it was not known by the header
  bool unit_of_name = false;      // the header names no unit, but is a name that usually has this
  std::optional<double> rate_hz;  // the times are k / rate_hz
  bool has_time = true;           // false: there is no time column, rate_hz is there
  bool counts_cycles = false;     // the times are k already, of which several rows have the same
  bool counts_each_sensor = false;  // the times are k already, from 0 for each sensor
  bool keep_origin = false;         // huge times stay as they are, and nothing is set back: one
                                    // sensor's file of several with one clock
  std::string column = "t";         // the time column's header, for messages
  std::string row = "line";         // what RawRows::line counts, for messages
};

// One entry a row, in the file's order.
struct RawRows {
  // Bits of the sensors; the first magnetometers have one each.
  static constexpr std::uint32_t kAcc = 1U, kGyr = 2U, kPosition = 1U << 28,
                                 kTemperature = 1U << 29, kCurrent = 1U << 30, kMoreMags = 1U << 31;
  static std::uint32_t mag(std::size_t i) { return i < 26 ? 4U << i : kMoreMags; }
  // All sensors but what a board logs beside them.
  static constexpr std::uint32_t kVectors = ~(kTemperature | kCurrent);
  // Bits of the sensors that row k has, without those that read the same again.
  std::uint32_t fresh(std::size_t k) const { return sensors[k] & ~(again.empty() ? 0U : again[k]); }

  std::vector<double> time;            // as in the file, times RowTimesOptions::unit
  std::vector<std::uint32_t> sensors;  // bits of the sensors that have a sample in it
  // Of these, the ones that read what a row before it of the same time says: a column that several
  // sensors' rows share. Empty: none.
  std::vector<std::uint32_t> again;
  std::vector<std::uint32_t> line;   // of the file
  std::vector<std::size_t> headers;  // rows before which the header line came again
};

struct RowTimes {
  std::vector<double> t;  // s; NaN: the row's time is damaged and the row left out
  double unit = 1.0;      // s that one of the column's numbers was taken for
  std::vector<std::string> notes, cautions;
};

// fail: throws for this line (0: none in particular), with problem and remedy.
using RowFailure =
    std::function<void(long line, const std::string& problem, const std::string& remedy)>;
RowTimes row_times(const RawRows& rows, const RowTimesOptions& options, const RowFailure& fail);

std::string late_rows_note(std::size_t rows);

// Of these alone, for streams, of which only the first rows are there (stream_times.h): seconds
// that one of the column's numbers is, where nobody said so. notes: what was recognised.
double recognised_time_unit(const RawRows& rows, const RowTimesOptions& options,
                            const RowFailure& fail, std::vector<std::string>& notes);

// Whether a time column counts samples: 0, 1, 2, ..., few of them lost. (A clock of whole seconds
// has many rows of one time.)
bool counts_samples(const RawRows& rows);
// Rows with the time of the row before and a sensor that it has, too: more than slips.
bool many_of_one_time(const RawRows& rows);

}  // namespace magimu
