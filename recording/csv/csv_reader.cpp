// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/csv_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "recording/csv/columns/csv_names.h"
#include "recording/csv/one_clock.h"

namespace magimu {
namespace {

// Bytes from which the dialect is recognised: more than any header has.
constexpr std::size_t kHeadBytes = 1 << 16;
// A thousand magnetometers take 50 kB. What goes on without a line end (/dev/zero) would fill all
// memory.
constexpr std::size_t kLongestTextLine = 1 << 20;

// Share of lines that may be broken, as a serial port breaks some. With more, the format is not
// understood. A file is not given up before so many lines.
constexpr double kFewBroken = 0.01;
constexpr std::size_t kLinesToGiveUp = 10000;

// A rate of less than one sample in a minute shows that the unit of time is wrong.
void note_odd_rate(Recording& recording) {
  const double rate = recording.acc.rate_hz();
  if (rate == 0.0 || rate >= 1.0) return;
  recording.notes.push_back(fmt::format(
      "the accelerometer has a sample every {} s: is the file's time in s? give its unit if not",
      1.0 / rate));
}

}  // namespace

void CsvReader::push(std::string_view piece, std::size_t size) {
  if (has_begun_) return lines(piece);
  size_ = size;
  head_ += piece;
  if (head_.size() >= kHeadBytes) begin(false);
}

void CsvReader::begin(bool whole) {
  has_begun_ = true;
  returns_ = head_.find('\n') == std::string::npos && head_.find('\r') != std::string::npos;
  if (returns_) std::ranges::replace(head_, '\r', '\n');
  std::string_view head = std::string_view(head_).substr(0, kHeadBytes);
  const bool all = whole && head.size() == head_.size();
  if (!all) head = head.substr(0, head.rfind('\n') + 1);
  if (head.find('\0') == std::string_view::npos) {
    dialect_ = recognised_dialect(head, path_, options_, elsewhere_);
  }
  expected_rows_ = expected_rows();
  if (dialect_.times_of.empty()) {
    parsers_.emplace_back(path_, options_);
    parsers_.back().whole_file(expected_rows_);
    if (!dialect_.plain()) parsers_.back().dialect(dialect_);
  } else {
    for (const auto& [sensor, time] : dialect_.times_of) {
      CsvDialect own = dialect_;
      CsvOptions options = options_;
      for (std::string& name : own.names) {
        const std::string meaning = csv_name(name).name;
        const bool its = name == time || meaning.starts_with(sensor);
        if (!its) name.clear();
      }
      options.columns[time] = "t";
      options.require_imu = options.require_mag = false;
      options.keep_origin = true;
      own.notes.clear();
      parsers_.emplace_back(path_, std::move(options));
      parsers_.back().whole_file(expected_rows_);
      parsers_.back().dialect(std::move(own));
    }
  }
  const std::string text = std::move(head_);
  whole_lines(text);
}

// For reserving; 0: not known (a pipe).
std::size_t CsvReader::expected_rows() const {
  const auto rows = static_cast<double>(std::ranges::count(head_, '\n'));
  if (size_ <= head_.size()) return static_cast<std::size_t>(size_ == 0 ? 0.0 : rows);
  constexpr double kMost = 1 << 24;  // a size may be no more than a claim (a file with holes)
  const double share = static_cast<double>(size_) / static_cast<double>(head_.size());
  return static_cast<std::size_t>(std::min(1.02 * rows * share, kMost));
}

void CsvReader::lines(std::string_view piece) {
  if (!returns_) return whole_lines(piece);
  std::string text(piece);
  std::ranges::replace(text, '\r', '\n');
  whole_lines(text);
}

void CsvReader::whole_lines(std::string_view piece) {
  while (true) {
    const std::size_t end = piece.find('\n');
    if (end == std::string_view::npos) break;
    if (begun_.empty()) {
      line(piece.substr(0, end));
    } else {
      begun_ += piece.substr(0, end);
      line(begun_);
      begun_.clear();
    }
    piece.remove_prefix(end + 1);
  }
  begun_ += piece;
  if (begun_.size() > kLongestTextLine) refuse_long_line();
}

void CsvReader::line(std::string_view text) {
  ++lines_;
  if (failed_ && text.find_first_not_of(" \t\r") != std::string_view::npos) {
    set_aside(*std::exchange(failed_, std::nullopt));
  }
  for (CsvParser& parser : parsers_) {
    try {
      parser.line(text);
    } catch (const ShortRow& error) {
      failed_ = error;
      failed_short_ = true;
    } catch (const InputError& error) {
      if (!parsers_.front().has_rows()) throw;
      failed_ = error;
      failed_short_ = false;
    }
  }
}

void CsvReader::set_aside(const InputError& error) {
  if (!parsers_.front().has_rows()) throw error;
  if (broken_++ == 0) first_broken_ = error;
  const std::size_t rows =
      std::max({expected_rows_, static_cast<std::size_t>(lines_), kLinesToGiveUp});
  if (double(broken_) > kFewBroken * double(rows)) throw *first_broken_;
}

// A recording that was cut off ends in the middle of a row.
void CsvReader::last_line_failed() {
  const bool cut = failed_short_ || at_end_;
  if (!parsers_.front().has_rows()) throw *failed_;
  if (cut) {
    cut_off_ = failed_->line;
  } else {
    set_aside(*failed_);
  }
}

void CsvReader::tell_set_aside(Recording& recording) const {
  if (broken_ == 0) return;
  const std::string text = fmt::format(
      "lines that cannot be read: {} of {}, the first in line {} ({}); they are left out", broken_,
      lines_, first_broken_->line, first_broken_->problem);
  recording.notes.push_back(text);
  recording.cautions.push_back(text);
}

void CsvReader::refuse_long_line() {
  if (begun_.find('\0') != std::string::npos)
    parsers_.front().line(begun_);  // line() fails with a message about binary content
  throw InputError(path_, lines_ + 1, 0,
                   fmt::format("this line is longer than {} bytes", kLongestTextLine),
                   "check that this is a CSV file, with a line for each sample");
}

Recording CsvReader::finish() {
  if (!has_begun_) begin(true);
  if (!begun_.empty()) {
    const bool failed_before = failed_.has_value();
    line(begun_);
    at_end_ = !failed_before;
  }
  if (failed_) last_line_failed();
  if (double(broken_) > kFewBroken * double(lines_)) throw *first_broken_;
  Recording recording;
  if (dialect_.times_of.empty()) {
    recording = parsers_.front().finish();
  } else {
    std::vector<Recording> parts;
    for (CsvParser& parser : parsers_) {
      if (parser.has_rows()) parts.push_back(parser.finish());
    }
    recording = joined(std::move(parts), path_, options_);
    recording.notes.insert(recording.notes.begin(), dialect_.notes.begin(), dialect_.notes.end());
    recording.notes.emplace_back("every sensor has times of its own in this file");
  }
  if (cut_off_ > 0) {
    const std::string text =
        fmt::format("the last row (line {}) is cut off; it is left out", cut_off_);
    recording.notes.push_back(text);
  }
  tell_set_aside(recording);
  recording.name = std::filesystem::path(path_).filename().string();
  note_odd_rate(recording);
  return recording;
}

}  // namespace magimu
