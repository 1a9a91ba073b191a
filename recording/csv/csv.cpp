// SPDX-License-Identifier: BSD-3-Clause
// CSV files: reading whole, and writing rows merged over the sensors' times.
#include "recording/csv/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <string_view>
#include <utility>

#include "recording/csv/csv_reader.h"
#include "recording/data/error.h"
#include "recording/data/well_formed.h"
#include "recording/files/atomic_file.h"
#include "recording/files/read_file.h"

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

// Appends the fields of one column to the row of time t; empty fields if the column has no sample
// at t.
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

// Some whole lines from places all over a text: where sensors come one after the other, the head
// does not show all of them. read: so many bytes from there, or none.
template <class Read>
std::string lines_from_all_over(std::size_t size, const Read& read) {
  constexpr std::size_t kPlaces = 16, kBytes = 1 << 12;
  std::string out;
  if (size < kPlaces * kBytes) return out;  // the head is enough
  for (std::size_t i = 1; i <= kPlaces; ++i) {
    const std::string bytes = read(i * (size / kPlaces) - kBytes, kBytes);
    std::string_view piece = bytes;
    piece = piece.substr(std::min(piece.find('\n') + 1, piece.size()));
    out += piece.substr(0, piece.rfind('\n') + 1);
  }
  return out;
}

std::string lines_from_all_over(const std::string& path, std::size_t size) {
  std::ifstream file(path, std::ios::binary);
  return lines_from_all_over(size, [&file](std::size_t from, std::size_t count) {
    std::string bytes(count, '\0');
    file.seekg(static_cast<std::streamoff>(from));
    if (!file.read(bytes.data(), static_cast<std::streamsize>(count))) bytes.clear();
    return bytes;
  });
}

}  // namespace

Recording read_csv(const std::string& path, const CsvOptions& options) {
  CsvReader reader(path, options);
  bool begun = false;
  read_file_in_pieces(path, [&](std::string_view piece, std::size_t size) {
    if (!std::exchange(begun, true) && size > 0) {
      reader.elsewhere(lines_from_all_over(path, size));
    }
    reader.push(piece, size);
  });
  return reader.finish();
}

Recording csv_recording(std::string_view content, const std::string& path,
                        const CsvOptions& options) {
  CsvReader reader(path, options);
  reader.elsewhere(
      lines_from_all_over(content.size(), [content](std::size_t from, std::size_t count) {
        return std::string(content.substr(from, count));
      }));
  reader.push(content, content.size());
  return reader.finish();
}

std::string csv_text(const Recording& recording) {
  require_well_formed(recording);
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
