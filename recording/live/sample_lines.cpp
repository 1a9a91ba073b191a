// SPDX-License-Identifier: BSD-3-Clause
// Lines out of pieces, samples out of lines (by CsvParser), and the order of their times.
#include "recording/live/sample_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/times/row_times.h"
#include "recording/data/told_units.h"

namespace magimu {
namespace {

constexpr std::size_t kLongestLine = 65536;  // a thousand magnetometers still fit
constexpr std::size_t kComplaints = 3;       // in full; the others are counted
// Late lines in a row, each after the one before: no damaged times and no lines in disorder.
constexpr std::size_t kClockWasSetBack = 10;
constexpr double kLateSensor = 1.0;  // s

bool is_blank_or_comment(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string_view::npos || text[first] == '#';
}

// No control codes, and no byte in front that continues a character of UTF-8.
bool is_text(std::string_view line) {
  const auto byte = [](char c) { return static_cast<unsigned char>(c); };
  if (!line.empty() && byte(line.front()) >= 0x80 && byte(line.front()) < 0xc0) return false;
  return std::ranges::none_of(line, [&](char c) { return byte(c) < 0x20 && c != '\t'; });
}

std::string_view without_line_end(std::string_view text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

// The one row that a parser has read; nothing where all its fields were empty.
std::optional<StreamSample> only_sample(const Recording& row) {
  StreamSample sample;
  bool any = false;
  const auto put = [&](const VectorSeries& series, std::optional<Vector3>& value) {
    if (series.empty()) return;
    sample.t = series.t.front();
    value = series.v.front();
    any = true;
  };
  sample.mag.resize(row.mag.size());
  put(row.acc, sample.acc);
  put(row.gyr, sample.gyr);
  for (std::size_t i = 0; i < row.mag.size(); ++i) put(row.mag[i], sample.mag[i]);
  if (!any) return std::nullopt;
  return sample;
}

template <class Body>
void for_each_sensor(const StreamSample& sample, const Body& body) {
  if (sample.acc) body(std::size_t(0), *sample.acc);
  if (sample.gyr) body(std::size_t(1), *sample.gyr);
  for (std::size_t m = 0; m < sample.mag.size(); ++m) {
    if (sample.mag[m]) body(2 + m, *sample.mag[m]);
  }
}

// Whether `after` may come after `before` though its time is not later: nearly the same time, and
// no sensor in both.
bool keeps_order(const StreamSample& before, const StreamSample& after) {
  if (after.t < before.t - kLateSensor) return false;
  bool apart = after.t > before.t;
  if (apart) return true;
  apart = !(before.acc && after.acc) && !(before.gyr && after.gyr);
  for (std::size_t m = 0; m < std::min(before.mag.size(), after.mag.size()); ++m) {
    apart = apart && !(before.mag[m] && after.mag[m]);
  }
  return apart;
}

}  // namespace

SampleLines::SampleLines(std::string source, SampleLinesOptions options)
    : source_(std::move(source)),
      options_(std::move(options)),
      parser_(source_, options_.csv),
      fresh_(parser_),
      half_line_(options_.midway) {
  options_.csv.header = options_.columns;
  head_.emplace(source_, options_.csv);
  if (options_.columns.empty()) return;
  CsvParser parser("--columns", options_.csv);
  parser.line(options_.columns);
  take_columns(std::move(parser));
}

void SampleLines::push(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    const std::string_view part = bytes.substr(0, end);
    if (!too_long_) buffer_ += part;
    if (buffer_.size() > kLongestLine) {
      too_long_ = true;
      buffer_.resize(64);  // enough to quote it
    }
    if (end == std::string_view::npos) return;
    bytes.remove_prefix(end + 1);
    line(buffer_);
    buffer_.clear();
  }
}

void SampleLines::interrupt() {
  buffer_.clear();
  too_long_ = false;
  half_line_ = true;
  options_.midway = true;
}

void SampleLines::finish() {
  if (!buffer_.empty()) line(std::exchange(buffer_, {}));
  if (head_ && head_->finish()) {
    begin();
  } else if (head_ && head_->failure() && !options_.midway) {
    throw *head_->failure();
  }
  in_seconds(times_.finish());
  skip_late();
  if (held_) release(*std::exchange(held_, std::nullopt));
}

void SampleLines::line(std::string_view text) {
  if (++line_number_ == 1 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  text = without_line_end(text);
  const bool half = std::exchange(half_line_, false);
  if (std::exchange(too_long_, false)) {
    ++counts_.lines;
    ++counts_.malformed;
    complain(fmt::format("{}:{}: a line of more than {} bytes, {}, is skipped", source_,
                         line_number_, kLongestLine, quoted_text(text)));
  } else {
    counts_.lines += is_blank_or_comment(text) ? 0 : 1;
    head_ ? head_line(text, half) : use_line(text, half);
  }
}

void SampleLines::head_line(std::string_view text, bool half) {
  if (line_number_ == 1 && !options_.midway && !is_text(text)) {
    throw InputError(source_, line_number_, 0,
                     "it begins with bytes that are no text, " + quoted_text(text) +
                         ": a stream is lines of CSV",
                     "calibrate a file of another format as a file (magimu calibrate FILE), or "
                     "decompress it on its way into the pipe");
  }
  if (head_->push({std::string(text), line_number_, half})) return begin();
  if (!options_.midway && head_->full() && head_->failure()) throw *head_->failure();
  no_header_yet(text);
}

// A source joined midway: a row of numbers, or many lines of anything, above the header.
void SampleLines::no_header_yet(std::string_view text) {
  if (!options_.midway || waits_ || is_blank_or_comment(text) || counts_.lines < 2) return;
  const bool numbers = text.find_first_not_of("0123456789+-.,;eE \t") == std::string_view::npos;
  if (!head_->failure() && (!numbers || has_header_)) return;
  waits_ = true;
  const std::string why = head_->failure() ? head_->failure()->problem : "it holds numbers";
  complain(fmt::format(
      "{}: {} is no header line ({}); waiting for one; if the source sends none, give it by "
      "--columns t,acc_x,...",
      source_, quoted_text(text), why));
}

// The dialect is known: the lines that waited are used.
void SampleLines::begin() {
  StreamHead head = *std::exchange(head_, std::nullopt);
  fresh_ = parser_ = head.parser();
  header_ = head.header();
  plain_ = head.plain();
  const std::vector<StreamHead::Line> rows = head.take_rows();
  CsvParser with_row = fresh_;  // knows, too, whether the times are times of the day
  for (const StreamHead::Line& line : rows) {
    try {
      with_row.line(line.text);
      if (with_row.has_rows()) break;
    } catch (const InputError&) {  // it is said of the row below
    }
  }
  take_columns(std::move(with_row));
  const long latest = line_number_;
  for (const StreamHead::Line& line : rows) {
    line_number_ = line.number;
    use_line(line.text, line.half);
  }
  line_number_ = latest;
}

void SampleLines::take_columns(CsvParser parser) {
  has_header_ = true;
  const Recording row = parser.take();
  mag_names_ = row.mag_names;
  notes_ = row.notes;
  file_units_ = row.file_units;
  tell_units(file_units_, options_.csv.acc_unit, options_.csv.gyr_unit, options_.csv.mag_unit);
  if (options_.recognise_times || options_.csv.rate_hz) {
    times_ = StreamTimes(parser.columns(), options_.csv);
  }
}

void SampleLines::use_line(std::string_view text, bool half) {
  if (is_blank_or_comment(text)) return;
  if (!header_.empty() && csv_trimmed(text) == header_) {
    ++counts_.headers;
  } else if (half) {
    header_again(text);  // a half line is no row, and no complaint
  } else {
    row(text);
  }
}

// Whether the line is a header, and dealt with.
bool SampleLines::header_again(std::string_view text) {
  if (!plain_) return false;
  CsvParser parser(source_, options_.csv);
  try {
    parser.line(text);
  } catch (const InputError&) {
    return false;
  }
  if (parser.take().mag_names != mag_names_) {
    ++counts_.malformed;
    complain(fmt::format(
        "{}:{}: a header with other magnetometers than before, {}, is skipped; start again if the "
        "sensors have changed",
        source_, line_number_, quoted_text(text)));
    return true;
  }
  ++counts_.headers;
  fresh_ = parser_ = std::move(parser);
  header_ = csv_trimmed(text);
  return true;
}

void SampleLines::row(std::string_view text) {
  try {
    parser_.line(text);
  } catch (const InputError&) {
    // The line, or only its time? A parser that has seen no time tells.
    CsvParser fresh = fresh_;
    try {
      fresh.line(text);
    } catch (const InputError& error) {
      if (header_again(text)) return;
      ++counts_.malformed;
      complain(fmt::format("{}:{}: {}: {} is skipped", source_, line_number_, error.problem,
                           quoted_text(text)));
      return;
    }
    parser_ = std::move(fresh);
  }
  std::optional<StreamSample> sample = only_sample(parser_.take());
  if (sample) in_seconds(times_.push(std::move(*sample)));
}

void SampleLines::in_seconds(std::vector<StreamSample>&& samples) {
  for (const std::string& note : times_.take_notes()) complain(source_ + ": " + note);
  for (StreamSample& sample : samples) order(std::move(sample));
}

void SampleLines::order(StreamSample sample) {
  sample.t += clock_s_;
  if (is_late_row_of_others(sample)) return release(sample);
  if (last_t_ && sample.t <= *last_t_) return late(std::move(sample));
  skip_late();
  if (!held_ || sample.t > held_->t || keeps_order(*held_, sample)) {
    if (held_) release(*held_);
    held_ = std::move(sample);
    return;
  }
  const double expected = last_t_.value_or(0.0) + usual_interval();
  const bool held_fits = last_t_ && std::abs(held_->t - expected) <= std::abs(sample.t - expected);
  if (!held_fits) std::swap(*held_, sample);
  skip(sample, held_fits ? fmt::format("does not come after {:.6g} s", held_->t)
                         : fmt::format("is followed by {:.6g} s", held_->t));
}

// Time increases for its own sensors.
bool SampleLines::is_late_row_of_others(const StreamSample& sample) const {
  if (!last_t_ || sample.t > *last_t_ || sample.t < *last_t_ - kLateSensor) return false;
  bool other = true;
  for_each_sensor(sample,
                  [&](std::size_t i, const Vector3&) { other = other && sample.t > sensor_t_[i]; });
  return other;
}

void SampleLines::late(StreamSample sample) {
  const bool goes_on = !late_.empty() && sample.t > late_.back().t;
  if (!goes_on) skip_late();
  late_.push_back(std::move(sample));
  if (late_.size() < kClockWasSetBack) return;
  if (held_) release(*std::exchange(held_, std::nullopt));
  const double step = *last_t_ + kPartGap - late_.front().t;
  complain(fmt::format(
      "{}: the clock was set back, from {:.6g} s to {:.6g} s (the board was reset?): a new part "
      "begins, its times go on at {:.6g} s",
      source_, *last_t_ - clock_s_, late_.front().t - clock_s_, *last_t_ + kPartGap));
  clock_s_ += step;
  ++counts_.set_back;
  for (StreamSample& s : std::exchange(late_, {})) {
    s.t += step;
    if (held_) release(*held_);
    held_ = std::move(s);
  }
}

void SampleLines::skip_late() {
  for (const StreamSample& s : std::exchange(late_, {})) {
    skip(s, fmt::format("does not come after {:.6g} s", *last_t_));
  }
}

void SampleLines::release(const StreamSample& sample) {
  if (last_t_ && sample.t > *last_t_) {
    intervals_[intervals_known_++ % intervals_.size()] = sample.t - *last_t_;
  }
  last_t_ = std::max(last_t_.value_or(sample.t), sample.t);
  sensor_t_.resize(2 + sample.mag.size(), -std::numeric_limits<double>::infinity());
  for_each_sensor(sample, [&](std::size_t i, const Vector3&) { sensor_t_[i] = sample.t; });
  ++counts_.samples;
  ready_.push_back(sample);
}

void SampleLines::skip(const StreamSample& sample, const std::string& why) {
  ++counts_.out_of_order;
  complain(fmt::format("{}:{}: the time {:.6g} s {}: that line is skipped", source_, line_number_,
                       sample.t, why));
}

// Median of the latest; 0 where there is none.
double SampleLines::usual_interval() const {
  std::array<double, 9> sorted = intervals_;
  const std::size_t n = std::min(intervals_known_, sorted.size());
  if (n == 0) return 0.0;
  std::ranges::sort(sorted.begin(), sorted.begin() + std::ptrdiff_t(n));
  return sorted[n / 2];
}

std::vector<StreamSample> SampleLines::take() { return std::exchange(ready_, {}); }

void SampleLines::complain(const std::string& sentence) {
  if (complaints_.size() < kComplaints) {
    complaints_.push_back(sentence);
  } else {
    ++more_complaints_;
  }
}

std::vector<std::string> SampleLines::take_complaints() {
  std::vector<std::string> out = std::exchange(complaints_, {});
  if (const long more = std::exchange(more_complaints_, 0); more > 0) {
    out.push_back(fmt::format("{}: and {} more lines skipped", source_, more));
  }
  return out;
}

}  // namespace magimu
