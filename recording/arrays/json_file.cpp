// SPDX-License-Identifier: BSD-3-Clause
// Gone through once, without a tree in memory: objects within an array become rows of a table,
// which the reader of text then reads; all other numbers become arrays by their names.
#include "recording/arrays/json_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "recording/arrays/arrays.h"
#include "recording/arrays/json_blocks.h"
#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/data/error.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

constexpr std::size_t kMostJsonColumns = 1000, kMostLevels = 64, kMostArrays = 10000;

// What nlohmann's parser calls. False ends it.
class Handler : public nlohmann::json_sax<nlohmann::json> {
 public:
  // by_line: each line is an object, which is a row.
  explicit Handler(bool by_line) : by_line_(by_line) {}

  bool null() override { return value(""); }
  bool boolean(bool v) override { return value(v ? "1" : "0"); }
  bool number_integer(number_integer_t v) override { return value(fmt::format("{}", v)); }
  bool number_unsigned(number_unsigned_t v) override { return value(fmt::format("{}", v)); }
  bool number_float(number_float_t, const string_t& text) override { return value(text); }
  bool string(string_t& v) override { return value(v); }
  bool binary(binary_t&) override { return false; }

  bool start_object(std::size_t) override {
    if (levels_.size() >= kMostLevels) return false;
    // The outermost object within an array is a row.
    const bool row =
        row_level_ == 0 && (levels_.empty() ? by_line_ : !by_line_ && levels_.back().is_array);
    levels_.push_back({false, row ? "" : path(), 0});
    if (row) row_level_ = levels_.size();
    return true;
  }
  bool key(string_t& name) override {
    Level& level = levels_.back();
    level.key = level.prefix.empty() ? name : level.prefix + "." + name;
    return true;
  }
  bool end_object() override {
    levels_.pop_back();
    if (!levels_.empty() && levels_.back().is_array) ++levels_.back().count;
    if (row_level_ > 0 && levels_.size() < row_level_) {
      end_row();
      row_level_ = 0;
    }
    return true;
  }
  bool start_array(std::size_t) override {
    if (levels_.size() >= kMostLevels) return false;
    levels_.push_back({true, path(), 0});
    return true;
  }
  bool end_array() override {
    const std::size_t count = levels_.back().count;
    const std::string name = levels_.back().prefix;
    levels_.pop_back();
    if (levels_.empty() || !levels_.back().is_array) return true;
    ++levels_.back().count;
    if (row_level_ == 0 && count > 0 && arrays_.contains(name)) arrays_[name].inner = count;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override {
    return false;
  }

  bool has_rows() const { return !rows_.empty(); }

  // The table of rows that hold several samples each (json_blocks.h); empty: they do not.
  std::string table_of_blocks() const {
    if (!has_blocks(columns_)) return "";
    std::vector<std::vector<std::string>> cells;
    for (const Row& row : rows_) cells.push_back(text_fields(row.text, ','));
    return spread_blocks(columns_, cells);
  }

  std::string table() const {
    std::string out;
    for (const std::string& column : columns_) out += (out.empty() ? "" : ",") + quoted(column);
    out += '\n';
    for (const Row& row : rows_) {
      if (is_about_the_recording(row)) continue;
      out += row.text;
      out.append(columns_.size() - row.cells, ',');
      out += '\n';
    }
    return out;
  }

  // {"sensors": [{"name": "accX", "units": "m/s2"}, ...], "values": [[...], ...]} (Edge Impulse):
  // the objects name the columns of the numbers. Empty where it is not so.
  std::string table_of_named_columns() const {
    if (!number_of_.contains("name") || rows_.empty()) return "";
    const auto values = std::ranges::find_if(arrays_, [this](const auto& entry) {
      const Array& array = entry.second;
      return array.inner == rows_.size() && array.inner > 1 &&
             array.values.size() % array.inner == 0;
    });
    if (values == arrays_.end()) return "";
    double interval_ms = 0.0;
    for (const auto& [name, array] : arrays_) {
      if (array.values.size() != 1) continue;
      if (name.ends_with("interval_ms")) interval_ms = array.values.front();
      if (name.ends_with("frequency")) interval_ms = 1000.0 / array.values.front();
    }
    std::string out = interval_ms > 0.0 ? "t (ms)," : "";
    for (const Row& row : rows_) out += (&row == &rows_.front() ? "" : ",") + column_name(row);
    const std::vector<double>& all = values->second.values;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::size_t column = i % values->second.inner, line = i / values->second.inner;
      out += column == 0 ? '\n' : ',';
      if (column == 0 && interval_ms > 0.0) out += fmt::format("{},", interval_ms * double(line));
      out += fmt::format("{}", all[i]);
    }
    return out + '\n';
  }

  // N x 3 of arrays of three, else N x 1.
  BroadFile arrays(const std::string& path) const {
    BroadFile file{path, {}, [this](const std::string& name) {
                     const Array& array = arrays_.at(name);
                     BroadField field;
                     field.columns = array.inner == 3 && array.values.size() % 3 == 0 ? 3 : 1;
                     field.rows = array.values.size() / field.columns;
                     field.values = array.values;
                     return field;
                   }};
    for (const auto& [name, array] : arrays_) file.names.push_back(name);
    return file;
  }

 private:
  struct Level {
    bool is_array;
    std::string prefix;  // its name
    std::size_t count;   // of an array: what is in it so far
    std::string key = {};
  };
  struct Row {
    std::string text;
    std::size_t cells = 0;              // of the text
    std::size_t filled = 0;             // of them
    std::vector<std::size_t> first_of;  // columns that have nothing in the rows before
  };
  struct Array {
    std::vector<double> values;
    std::size_t inner = 0;  // of the innermost array
  };

  // Of what comes next. Elements of a row's arrays have numbers.
  std::string path() const {
    if (levels_.empty()) return "";
    const Level& level = levels_.back();
    if (!level.is_array) return level.key;
    return row_level_ > 0 ? fmt::format("{}[{}]", level.prefix, level.count) : level.prefix;
  }

  static std::string quoted(const std::string& text) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) {
      if (c == '"') out += '"';
      out += c == '\n' || c == '\r' ? ' ' : c;
    }
    return out + '"';
  }

  // "accX (m/s2)" of a row with the cells name and units.
  std::string column_name(const Row& row) const {
    const std::vector<std::string> cells = text_fields(row.text, ',');
    const auto cell = [&](const char* name) {
      const auto column = number_of_.find(name);
      const bool there = column != number_of_.end() && column->second < cells.size();
      return there ? cells[column->second] : std::string();
    };
    const std::string unit = cell("units").empty() ? cell("unit") : cell("units");
    return quoted(unit.empty() ? cell("name") : cell("name") + " (" + unit + ")");
  }

  bool value(const std::string& text) {
    if (levels_.empty()) return true;
    if (row_level_ > 0) {
      cell(path(), text);
    } else if (!number(text)) {
      return false;
    }
    if (levels_.back().is_array) ++levels_.back().count;
    return true;
  }

  void cell(const std::string& name, const std::string& text) {
    auto column = number_of_.find(name);
    if (column == number_of_.end()) {
      if (columns_.size() >= kMostJsonColumns) return;
      column = number_of_.emplace(name, columns_.size()).first;
      columns_.push_back(name);
    }
    if (cells_.size() <= column->second) cells_.resize(column->second + 1);
    cells_[column->second] = quoted(text);
  }

  void end_row() {
    std::string text;
    for (std::size_t i = 0; i < cells_.size(); ++i) text += (i > 0 ? "," : "") + cells_[i];
    Row row{std::move(text), cells_.size(), 0, {}};
    filled_.resize(columns_.size());
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (cells_[i].empty()) continue;
      ++row.filled;
      if (filled_[i]++ == 0) row.first_of.push_back(i);
    }
    if (!cells_.empty()) rows_.push_back(std::move(row));
    cells_.clear();
  }

  // {"sensor": "Metadata", "version": "3", ...} of Sensor Logger: nothing of it is in other rows,
  // but the word that says what a row is.
  bool is_about_the_recording(const Row& row) const {
    constexpr std::size_t kFewRows = 10;  // too few to tell
    if (rows_.size() < kFewRows || row.filled < 2) return false;
    std::size_t alone = 0;
    for (const std::size_t column : row.first_of) alone += filled_[column] == 1 ? 1 : 0;
    return alone + 1 >= row.filled;
  }

  // Of an array, or of an object with a key for each row (pandas).
  bool number(const std::string& text) {
    const Level& level = levels_.back();
    const bool numbered =
        !level.is_array && !level.prefix.empty() &&
        level.key.find_first_not_of("0123456789", level.prefix.size() + 1) == std::string::npos;
    const std::string& name = numbered ? level.prefix : level.is_array ? level.prefix : level.key;
    double value = std::numeric_limits<double>::quiet_NaN();
    const char* const end = text.data() + text.size();
    const bool is_number = std::from_chars(text.data(), end, value).ptr == end && !text.empty();
    if (!is_number && !level.is_array && !numbered) return true;  // text about the recording
    if (arrays_.size() >= kMostArrays && !arrays_.contains(name)) return true;
    arrays_[name].values.push_back(value);
    return true;
  }

  std::vector<Level> levels_;
  bool by_line_;
  std::size_t row_level_ = 0;  // levels from the outermost to the row's object; 0: no row is read
  std::vector<std::string> columns_, cells_;
  std::map<std::string, std::size_t> number_of_;
  std::vector<std::size_t> filled_;  // by column: in how many rows
  std::vector<Row> rows_;
  std::map<std::string, Array> arrays_;
};

// Does a line have an array of objects, such as "ArrayAcc":[{"x":?
bool has_arrays_of_objects(std::string_view line) {
  for (std::size_t at = line.find('['); at != line.npos; at = line.find('[', at + 1)) {
    if (const std::size_t next = line.find_first_not_of(" \t", at + 1);
        next != line.npos && line[next] == '{') {
      return true;
    }
  }
  return false;
}

// Whether the first line is a whole object and the second begins another.
bool has_objects_by_line(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string first, second;
  std::getline(file, first);
  std::getline(file, second);
  return csv_trimmed(first).starts_with('{') && csv_trimmed(second).starts_with('{') &&
         nlohmann::json::accept(first);
}

// False where the text is cut off or damaged.
bool parse(const std::string& path, bool by_line, Handler& handler) {
  std::ifstream file(path, std::ios::binary);
  if (!by_line) return nlohmann::json::sax_parse(file, &handler);
  for (std::string line; std::getline(file, line);) {
    if (!csv_trimmed(line).empty() && !nlohmann::json::sax_parse(line, &handler)) return false;
  }
  return true;
}

}  // namespace

bool is_json_table(const std::string& path, std::string_view head) {
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || head.find("\"format\": \"magimu-") != head.npos)
    return false;
  const std::size_t second = head.find_first_not_of(" \t\r\n", first + 1);
  const char after = second == std::string_view::npos ? '\0' : head[second];
  if (head[first] == '[') return after == '{';
  if (head[first] != '{' || after != '"') return false;
  // Lines of an object each are read as text, unless an object holds several samples.
  const std::string more = read_file_head(path, 1 << 16);
  const std::size_t end = more.find('\n', first);
  if (end == std::string::npos) return true;
  const std::size_t next = more.find_first_not_of(" \t\r\n", end);
  const std::string_view line = csv_trimmed(std::string_view(more).substr(first, end - first));
  return !(line.ends_with("}") || line.ends_with("}\r")) || next == std::string::npos ||
         more[next] != '{' || has_arrays_of_objects(line);
}

Recording read_json(const std::string& path, const CsvOptions& options) {
  const bool by_line = has_objects_by_line(path);
  Handler handler(by_line);
  const bool whole = parse(path, by_line, handler);
  constexpr const char* kCut = "the JSON text is cut off or damaged; what is before that is read";
  const std::string named = handler.table_of_named_columns();
  const std::string blocks = named.empty() ? handler.table_of_blocks() : "";
  Recording out = !named.empty()       ? csv_recording(named, path, options)
                  : !blocks.empty()    ? csv_recording(blocks, path, options)
                  : handler.has_rows() ? csv_recording(handler.table(), path, options)
                                       : recording_from_arrays(handler.arrays(path), options);
  out.notes.insert(out.notes.begin(),
                   !named.empty()    ? "this is JSON, an array a row, with names and units"
                   : !blocks.empty() ? "this is JSON, several samples a row: its time is that of "
                                       "the first, and they are evenly spaced"
                   : handler.has_rows() ? "this is JSON, an object a row"
                                        : "this is JSON, with an array a quantity");
  if (!whole) {
    out.notes.emplace_back(kCut);
    out.cautions.emplace_back(kCut);
  }
  return out;
}

}  // namespace magimu
