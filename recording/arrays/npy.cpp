// SPDX-License-Identifier: BSD-3-Clause
// numpy's array files (numpy.lib.format, versions 1 to 3): a Python dictionary that says what the
// numbers behind it are.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <memory>

#include "recording/arrays/arrays.h"
#include "recording/data/error.h"
#include "recording/files/half_float.h"
#include "recording/files/log_file.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

struct NpyField {
  std::string name;
  char kind = 0;  // f, i, u, b
  std::size_t size = 0, offset = 0, columns = 1;
  bool swapped = false;
};

class NpyHeader {
 public:
  NpyHeader(std::string_view text, const std::string& path) : text_(text), path_(path) {}

  std::vector<NpyField> fields;
  std::vector<std::size_t> shape;
  bool fortran = false;
  std::size_t item = 0;  // bytes

  void parse() {
    fortran = text_.find("'fortran_order': True") != std::string_view::npos;
    const std::size_t at = text_.find("'shape':");
    if (at == std::string_view::npos) damaged();
    for (const std::size_t n : numbers(text_.substr(at, text_.find(')', at) - at)))
      shape.push_back(n);
    const std::size_t descr = text_.find("'descr':");
    if (descr == std::string_view::npos) damaged();
    std::string_view rest = text_.substr(descr + 8);
    rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
    if (rest.starts_with('\'')) {
      add("", rest.substr(1, rest.find('\'', 1) - 1), 1);
    } else {
      structured(rest);
    }
    if (fields.empty() || shape.size() > 2) damaged();
  }

  [[noreturn]] void damaged() const {
    throw InputError(path_, 0, 0, "this array is none of numbers, or the file is damaged",
                     "save plain arrays (numpy.savez(FILE, t=..., acc=..., gyr=..., mag=...))");
  }

 private:
  static std::vector<std::size_t> numbers(std::string_view text) {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < text.size();) {
      std::size_t value = 0;
      const auto [end, error] = std::from_chars(text.data() + i, text.data() + text.size(), value);
      if (error == std::errc()) {
        out.push_back(value);
        i = static_cast<std::size_t>(end - text.data());
      } else {
        ++i;
      }
    }
    return out;
  }

  // ('t', '<f8'), ('acc', '<f4', (3,)), ...
  void structured(std::string_view text) {
    text = text.substr(0, text.find(']'));
    std::size_t at = 0;
    constexpr std::size_t kMostFields = 1000;
    while ((at = text.find("('", at)) != std::string_view::npos && fields.size() < kMostFields) {
      const std::size_t name_end = text.find('\'', at + 2);
      if (name_end == std::string_view::npos) damaged();
      const std::string_view name = text.substr(at + 2, name_end - at - 2);
      const std::size_t type = text.find('\'', name_end + 1);
      if (type == std::string_view::npos) damaged();
      const std::size_t type_end = text.find('\'', type + 1);
      if (type_end == std::string_view::npos) damaged();
      std::size_t columns = 1;
      at = type_end + 1;
      const std::size_t close = text.find(')', at);
      const std::size_t open = text.find('(', at);
      if (open < close && open != std::string_view::npos) {
        for (const std::size_t n : numbers(text.substr(open, close - open))) {
          columns *= std::min<std::size_t>(n, 100000);
          columns = std::min<std::size_t>(columns, 100000);
        }
        at = close;
      }
      add(std::string(name), text.substr(type + 1, type_end - type - 1), columns);
    }
  }

  void add(const std::string& name, std::string_view type, std::size_t columns) {
    NpyField field;
    field.name = name;
    field.columns = columns;
    field.offset = item;
    if (type.size() < 2) damaged();
    field.swapped = type.front() == '>';
    const bool mark = std::string_view("<>|=").find(type.front()) != std::string_view::npos;
    const std::vector<std::size_t> size = numbers(type.substr(mark ? 2 : 1));
    field.kind = type[mark ? 1 : 0];
    if (size.size() != 1 || size[0] > 100000) damaged();
    field.size = size[0] * (field.kind == 'U' ? 4 : 1);
    item += field.size * columns;
    fields.push_back(field);
  }

  std::string_view text_;
  const std::string& path_;
};

double npy_number(std::string_view bytes, std::size_t at, const NpyField& field) {
  const bool s = field.swapped;
  switch (field.kind) {
    case 'f':
      return field.size == 8   ? bytes_as<double>(bytes, at, s)
             : field.size == 4 ? double(bytes_as<float>(bytes, at, s))
             : field.size == 2 ? half_float(bytes_as<std::uint16_t>(bytes, at, s))
                               : std::numeric_limits<double>::quiet_NaN();
    case 'i':
      return field.size == 8   ? double(bytes_as<std::int64_t>(bytes, at, s))
             : field.size == 4 ? double(bytes_as<std::int32_t>(bytes, at, s))
             : field.size == 2 ? double(bytes_as<std::int16_t>(bytes, at, s))
                               : double(bytes_as<std::int8_t>(bytes, at));
    case 'M':  // times: datetime64, in its own unit
      return double(bytes_as<std::int64_t>(bytes, at, s));
    case 'u':
      return field.size == 8   ? double(bytes_as<std::uint64_t>(bytes, at, s))
             : field.size == 4 ? double(bytes_as<std::uint32_t>(bytes, at, s))
             : field.size == 2 ? double(bytes_as<std::uint16_t>(bytes, at, s))
                               : double(bytes_as<std::uint8_t>(bytes, at));
    case 'b':
      return bytes_as<std::uint8_t>(bytes, at);
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace

void add_npy(const std::string& content, const std::string& name, BroadFile& file) {
  const std::string& path = file.path;
  auto header_of = [&] {
    const bool large = content.size() > 6 && content[6] >= 2;
    const std::size_t length =
        large ? bytes_as<std::uint32_t>(content, 8) : bytes_as<std::uint16_t>(content, 8);
    const std::size_t begin = large ? 12 : 10;
    if (content.size() < begin || length > content.size() - begin) {
      throw InputError(path, 0, 0, "the numpy file is cut off", "give another copy of it");
    }
    return std::pair(std::string_view(content).substr(begin, length), begin + length);
  };
  const auto [text, data_at] = header_of();
  NpyHeader header(text, path);
  header.parse();
  const std::size_t rows = header.shape.empty() ? 1 : header.shape[0];
  const std::size_t columns = header.shape.size() < 2 ? 1 : header.shape[1];
  const std::size_t bytes = content.size() - data_at;
  if (header.item == 0 || rows > bytes / header.item ||
      (rows > 0 && columns > bytes / header.item / rows)) {
    header.damaged();
  }
  const auto earlier = file.read;
  std::vector<std::string> own;
  for (const NpyField& field : header.fields) {
    own.push_back(field.name.empty() ? name
                                     : (name.empty() ? field.name : name + "." + field.name));
    file.names.push_back(own.back());
  }
  const std::string_view data = std::string_view(content).substr(data_at);
  file.read = [earlier, own, header, rows, columns, data](const std::string& wanted) {
    const auto at = std::ranges::find(own, wanted);
    if (at == own.end()) return earlier(wanted);
    const NpyField& field = header.fields[static_cast<std::size_t>(at - own.begin())];
    if (std::string_view("fiubM").find(field.kind) == std::string_view::npos) header.damaged();
    BroadField out;
    // A plain matrix has its columns as dimension; a structured array in each item.
    const bool matrix = header.fields.size() == 1 && field.columns == 1;
    out.rows = rows;
    out.columns = matrix ? columns : field.columns;
    out.values.reserve(out.rows * out.columns);
    for (std::size_t r = 0; r < out.rows; ++r) {
      for (std::size_t c = 0; c < out.columns; ++c) {
        const std::size_t offset =
            matrix ? (header.fortran ? c * rows + r : r * columns + c) * header.item
                   : r * header.item + field.offset + c * field.size;
        out.values.push_back(npy_number(data, offset, field));
      }
    }
    return out;
  };
}

Recording read_npy(const std::string& path, const CsvOptions& options) {
  const std::string content = read_file(path);
  BroadFile file{path, {}, [&path](const std::string& name) -> BroadField {
                   throw InputError(path, 0, 0, "there is no array " + name, "");
                 }};
  add_npy(content, "", file);
  // A nameless matrix has the columns that --columns says.
  if (file.names.size() == 1 && file.names.front().empty()) {
    const BroadField whole = file.read("");
    std::string text = options.header + '\n';
    if (options.header.empty()) {
      throw InputError(path, 0, 0,
                       fmt::format("this is one array of {} x {} numbers, without names",
                                   whole.rows, whole.columns),
                       "name its columns (--columns t,acc_x,...), or save them by their names: "
                       "numpy.savez(FILE, t=..., acc=..., gyr=..., mag=...)");
    }
    for (std::size_t r = 0; r < whole.rows; ++r) {
      for (std::size_t c = 0; c < whole.columns; ++c) {
        text += fmt::format("{}{}", c == 0 ? "" : ",", whole.values[r * whole.columns + c]);
      }
      text += '\n';
    }
    return csv_recording(text, path, options);
  }
  return recording_from_arrays(file, options);
}

}  // namespace magimu
