// SPDX-License-Identifier: BSD-3-Clause
// The times of a stream in seconds, from what its time column holds. What that is in, the first
// rows tell, by the rules that files are read by (row_times.h): ms, us or ns are recognised, since
// 1970 or since boot; what is ambiguous, or counts samples, is refused with the option that helps,
// and asked again of the next rows. Samples that were stamped on arrival, several at a time, are
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
  // Nothing more comes: what the rows so far tell.
  std::vector<StreamSample> finish();

  // What was recognised, since the last call.
  std::vector<std::string> take_notes();
  // While nothing can be told; the rows are lost meanwhile.
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
