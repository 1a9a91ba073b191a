// SPDX-License-Identifier: BSD-3-Clause
// Samples from text that arrives in pieces, cut anywhere: the dialects of csv.h (stream_head.h),
// but where a file with many damaged lines is refused, a stream has to go on. A line that cannot be
// read is counted, quoted and skipped, and so is one whose time does not fit in; nothing else is
// lost with it.
//
//   SampleLines lines("serial:/dev/ttyUSB0");
//   while (read(bytes)) {
//     lines.push(bytes);
//     for (const StreamSample& sample : lines.take()) use(sample);
//     for (const std::string& sentence : lines.take_complaints()) warn(sentence);
//   }
//
// A damaged time must not make all that follows look late. So every sample waits for the next line,
// and where the two contradict each other the one that is further from the usual pace goes. Lines
// of other sensors that come a little late are none of that: time increases for each sensor. A
// clock that was set back (the board was reset) shows by lines that all go on from there: their
// times continue kPartGap (row_times.h) after the last one, as a file's do.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/csv_parser.h"
#include "recording/data/stream_sample.h"
#include "recording/live/stream_head.h"
#include "recording/live/stream_times.h"

namespace magimu {

struct SampleLinesOptions {
  CsvOptions csv;
  // The header line of a source that sends none, or sends it only once. Default: among the first
  // lines.
  std::string columns;
  // The source was joined while it was sending (a serial port): its first line may be the end of
  // one, and the header may come later. Otherwise first lines without one are an InputError.
  bool midway = false;
  // Where nobody says what the times are in, the first rows tell (stream_times.h). Otherwise they
  // are in seconds.
  bool recognise_times = false;
};

// Not thread safe.
class SampleLines {
 public:
  struct Counts {
    long lines = 0;         // with content, headers included
    long samples = 0;       // handed out, or ready to be
    long headers = 0;       // sent again after the first one
    long malformed = 0;     // lines that cannot be read
    long out_of_order = 0;  // lines whose time does not increase, or jumped ahead for one line
    long set_back = 0;      // times that the clock was set back
  };

  // `source` names it in messages.
  explicit SampleLines(std::string source, SampleLinesOptions options = {});

  void push(std::string_view bytes);
  // The source broke off: half a line is lost, and what comes next may begin with the end of one.
  void interrupt();
  // Nothing more will come: the last line needs no line end, and its sample no longer waits.
  void finish();

  std::vector<StreamSample> take();
  // What went wrong since the last call, in sentences: a few, and how many more there were.
  std::vector<std::string> take_complaints();

  // Known as soon as the header is.
  bool has_header() const { return has_header_; }
  const std::vector<std::string>& mag_names() const { return mag_names_; }
  const std::vector<std::string>& notes() const { return notes_; }  // the column mapping in words
  // The source's units in ours, as Recording::file_units.
  const std::map<std::string, double>& file_units() const { return file_units_; }
  // Where the time column cannot be understood: no samples come out meanwhile.
  const std::optional<RefusedTimes>& refused_times() const { return times_.refused(); }
  const Counts& counts() const { return counts_; }

 private:
  void line(std::string_view text);
  void head_line(std::string_view text, bool half);
  void no_header_yet(std::string_view text);
  void begin();
  void take_columns(CsvParser parser);
  void use_line(std::string_view text, bool half);
  bool header_again(std::string_view text);
  void row(std::string_view text);
  void in_seconds(std::vector<StreamSample>&& samples);
  void order(StreamSample sample);
  bool is_late_row_of_others(const StreamSample& sample) const;
  void late(StreamSample sample);
  void skip_late();
  void release(const StreamSample& sample);
  void skip(const StreamSample& sample, const std::string& why);
  double usual_interval() const;
  void complain(const std::string& sentence);

  std::string source_;
  SampleLinesOptions options_;
  std::optional<StreamHead> head_;  // until the dialect is known
  CsvParser parser_, fresh_;        // fresh_: knows the columns, has read no row
  bool has_header_ = false, plain_ = false;
  std::string header_;  // the line as it came; empty: there is none
  std::vector<std::string> mag_names_, notes_;
  std::map<std::string, double> file_units_;
  StreamTimes times_;
  Counts counts_;

  std::string buffer_;      // the line that has begun to arrive
  bool half_line_ = false;  // ... may be the end of one
  bool too_long_ = false;   // ... is dropped up to its end
  long line_number_ = 0;    // of the source, from 1
  bool waits_ = false;      // said that there is no header yet
  // Lines whose time does not increase, without one that does: of a clock that was set back?
  std::vector<StreamSample> late_;
  double clock_s_ = 0.0;  // what is added to the source's times
  std::optional<StreamSample> held_;
  std::optional<double> last_t_;       // of the latest sample released
  std::vector<double> sensor_t_;       // of accelerometer, gyroscope, magnetometers
  std::array<double, 9> intervals_{};  // the latest ones, in a ring
  std::size_t intervals_known_ = 0;
  std::vector<StreamSample> ready_;
  std::vector<std::string> complaints_;
  long more_complaints_ = 0;
};

}  // namespace magimu
