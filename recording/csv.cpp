// SPDX-License-Identifier: BSD-3-Clause
// CSV files: reading whole, and writing rows merged over the sensors' times.
#include "recording/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <utility>

#include "recording/atomic_file.h"
#include "recording/csv_parser.h"
#include "recording/error.h"
#include "recording/read_file.h"

namespace magimu {
namespace {

// One sensor's columns in the file to be written.
struct Column {
  std::string name;
  const std::vector<double>* t;
  const std::vector<Vector3>* vectors;  // exactly one of these two is there
  const std::vector<double>* scalars;
  std::size_t next = 0;

  bool done() const { return next == t->size(); }
  double time() const { return (*t)[next]; }
};

std::vector<Column> columns_of(const Recording& recording) {
  std::vector<Column> columns;
  const auto add = [&](const std::string& name, const VectorSeries& series) {
    columns.push_back({name, &series.t, &series.v, nullptr});
  };
  add("acc", recording.acc);
  add("gyr", recording.gyr);
  for (std::size_t i = 0; i < recording.mag.size(); ++i) {
    const bool named = i < recording.mag_names.size();
    add(named ? recording.mag_names[i] : "mag" + std::to_string(i + 1), recording.mag[i]);
  }
  for (const auto& [name, series] : recording.aux) {
    columns.push_back({name, &series.t, nullptr, &series.v});
  }
  if (recording.pos) add("pos", *recording.pos);
  return columns;
}

void append(std::string& text, double value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

void append_header(std::string& text, const std::vector<Column>& columns) {
  text += "t";
  for (const Column& column : columns) {
    if (column.scalars != nullptr) {
      text += "," + column.name;
      continue;
    }
    for (const char* axis : {"_x", "_y", "_z"}) text += "," + column.name + axis;
  }
  text += "\n";
}

// The fields of one column in the row of time t; empty ones if it has no sample then.
void append_fields(std::string& text, Column& column, double t) {
  const bool has_sample = !column.done() && !(column.time() > t);
  for (int axis = 0; axis < (column.vectors != nullptr ? 3 : 1); ++axis) {
    text += ',';
    if (!has_sample) continue;
    append(text, column.vectors != nullptr ? (*column.vectors)[column.next][axis]
                                           : (*column.scalars)[column.next]);
  }
  if (has_sample) ++column.next;
}

// A file's rate tells a forgotten time unit: no IMU samples once in minutes.
void note_odd_rate(Recording& recording) {
  const double rate = recording.acc.rate_hz();
  if (rate == 0.0 || rate >= 1.0) return;
  std::string note = "the accelerometer has a sample every ";
  append(note, 1.0 / rate);
  recording.notes.push_back(note + " s: is the file's time in s? give its unit if not");
}

// Hands a parser the lines of a text that comes in pieces.
class LinesOfPieces {
 public:
  LinesOfPieces(CsvParser& parser, const std::string& path) : parser_(parser), path_(path) {}

  void push(std::string_view piece) {
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
    if (begun_.size() > kLongestLine) refuse_long_line();
  }

  void finish() {
    if (!begun_.empty()) line(begun_);
  }

 private:
  // A thousand magnetometers take 50 kB. What goes on without a line end (/dev/zero) would fill all
  // memory.
  static constexpr std::size_t kLongestLine = 1 << 20;

  void line(std::string_view text) {
    ++lines_;
    parser_.line(text);
  }
  void refuse_long_line() {
    if (begun_.find('\0') != std::string::npos) line(begun_);  // binary content: it says so
    throw InputError(path_, lines_ + 1, 0,
                     fmt::format("this line is longer than {} bytes", kLongestLine),
                     "check that this is a CSV file, with a line for each sample");
  }

  CsvParser& parser_;
  const std::string& path_;
  std::string begun_;  // a line whose end has not come yet
  long lines_ = 0;     // that have ended
};

// Rows of a file of `size` bytes that begins with this piece, for reserving; 0: not known (a pipe).
std::size_t expected_rows(std::string_view piece, std::size_t size) {
  const auto lines = static_cast<double>(std::ranges::count(piece, '\n'));
  if (size <= piece.size()) return static_cast<std::size_t>(size == 0 ? 0.0 : lines);
  constexpr double kMost = 1 << 24;  // a size may be no more than a claim (a file with holes)
  const double share = static_cast<double>(size) / static_cast<double>(piece.size());
  return static_cast<std::size_t>(std::min(1.02 * lines * share, kMost));
}

void refuse_binary_pipe(const std::string& path, std::string_view head) {
  if (!head.starts_with("\x89HDF\r\n\x1a\n") && !head.starts_with("MATLAB ")) return;
  throw InputError(path, 0, 0, "HDF5 and MAT files cannot be read from a pipe",
                   "give the path of the file itself");
}

Recording finished(CsvParser& parser, const std::string& path) {
  Recording recording = parser.finish();
  recording.name = std::filesystem::path(path).filename().string();
  note_odd_rate(recording);
  return recording;
}

}  // namespace

Recording read_csv(const std::string& path, const CsvOptions& options) {
  CsvParser parser(path, options);
  LinesOfPieces lines(parser, path);
  bool begun = false;
  read_file_in_pieces(path, [&](std::string_view piece, std::size_t size) {
    if (!std::exchange(begun, true)) {
      if (size == 0) refuse_binary_pipe(path, piece);
      parser.whole_file(expected_rows(piece, size));
    }
    lines.push(piece);
  });
  if (!begun) parser.whole_file(0);
  lines.finish();
  return finished(parser, path);
}

Recording csv_recording(std::string_view content, const std::string& path,
                        const CsvOptions& options) {
  CsvParser parser(path, options);
  LinesOfPieces lines(parser, path);
  parser.whole_file(static_cast<std::size_t>(std::ranges::count(content, '\n')));
  lines.push(content);
  lines.finish();
  return finished(parser, path);
}

std::string csv_text(const Recording& recording) {
  std::vector<Column> columns = columns_of(recording);
  std::string text;
  append_header(text, columns);
  while (true) {
    const Column* first = nullptr;  // the one whose next sample is earliest
    for (const Column& column : columns) {
      if (!column.done() && (first == nullptr || column.time() < first->time())) first = &column;
    }
    if (first == nullptr) break;
    const double t = first->time();
    append(text, t);
    for (Column& column : columns) append_fields(text, column, t);
    text += '\n';
  }
  return text;
}

void write_csv(const Recording& recording, const std::string& path) {
  write_atomically(path, csv_text(recording));
}

}  // namespace magimu
