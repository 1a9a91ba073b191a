// SPDX-License-Identifier: BSD-3-Clause
// The times of a stream in seconds, from the numbers in its time column. The first rows tell the
// unit, by the same rules as for files (row_times.h): ms, us or ns are recognised, since 1970 or
// since boot. A column that is ambiguous, or counts samples, is refused with the option that helps;
// the next rows are then tried again. Samples that were stamped on arrival, several at a time, are
// given even times (arrival_stamps.h). With a rate given the times are k / rate.
//
//   StreamTimes times(columns, options);
//   for (const StreamSample& sample : times.push(as_in_the_column)) use(sample);
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/csv/columns/csv_columns.h"
#include "recording/data/stream_sample.h"
#include "recording/data/times/arrival_stamps.h"
#include "recording/data/times/row_times.h"

namespace magimu {

// Why the times of a stream cannot be told, and what to do.
struct RefusedTimes {
  std::string problem, remedy;
};

// Not thread safe.
class StreamTimes {
 public:
  StreamTimes() = default;  // samples pass as they are
  StreamTimes(const CsvColumns& columns, const CsvOptions& options);

  // The samples whose times are known by now: none until the first rows have come, then all of
  // them. raw.t: the column's number, times the unit that is given.
  std::vector<StreamSample> push(StreamSample raw);
  // The stream has ended: decides by the rows that have come. The samples that were still held.
  std::vector<StreamSample> finish();

  // Sentences about what was recognised since the last call.
  std::vector<std::string> take_notes();
  // Why the last rows were refused; empty: they were not. Rows that were refused are lost.
  const std::optional<RefusedTimes>& refused() const { return refused_; }

 private:
  std::vector<StreamSample> decide(bool last);
  std::vector<StreamSample> refuse(RefusedTimes why);
  StreamSample timed(StreamSample raw);

  RowTimesOptions options_;
  bool known_ = true;
  double unit_ = 1.0;
  bool counter_ = false;          // with a rate: the column counts samples
  std::optional<double> origin_;  // of that counter
  double row_ = 0.0;              // k, where no counter tells
  std::optional<EvenPace> pace_;  // stamped on arrival
  std::vector<StreamSample> held_;
  std::vector<std::string> notes_;
  std::optional<RefusedTimes> refused_;
};

}  // namespace magimu
