// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/long_format_dialect.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "recording/csv/csv_names.h"
#include "recording/csv/text_fields.h"
#include "recording/csv/words.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

class LongFormatFinder {
 public:
  LongFormatFinder(const std::vector<HeadLine>& lines, const std::vector<HeadLine>& elsewhere,
                   const TableShape& shape, CsvDialect& dialect)
      : lines_(lines), elsewhere_(elsewhere), shape_(shape), dialect_(dialect) {}

  bool find() {
    const std::size_t columns = shape_.fields;
    std::vector<std::vector<std::string>> words(columns);  // of each column, in their order
    std::vector<std::size_t> numbers(columns, 0), rows_of(columns, 0);
    std::vector<HeadLine> rows(lines_.begin() + std::ptrdiff_t(shape_.first_row), lines_.end());
    rows.insert(rows.end(), elsewhere_.begin(), elsewhere_.end());
    for (const HeadLine& row : rows) {
      if (is_comment(row.text)) continue;
      const std::vector<std::string> fields = text_fields(row.text, shape_.separator);
      for (std::size_t c = 0; c < columns && c < fields.size(); ++c) {
        const FieldKind kind = field_kind(fields[c]);
        ++rows_of[c];
        if (kind != FieldKind::kWord && kind != FieldKind::kEmpty) ++numbers[c];
        if (kind == FieldKind::kWord && words[c].size() < 64 &&
            std::ranges::find(words[c], fields[c]) == words[c].end()) {
          words[c].push_back(fields[c]);
        }
      }
    }
    for (std::size_t c = 0; c < columns; ++c) {
      if (numbers[c] == 0 && long_format_by(c, words[c], numbers, rows_of)) {
        if (one_sensor_after_the_other(rows)) times_of_words();
        return true;
      }
    }
    return false;
  }

 private:
  bool long_format_by(std::size_t word_column, const std::vector<std::string>& words,
                      const std::vector<std::size_t>& numbers,
                      const std::vector<std::size_t>& rows) {
    LongFormat format;
    format.separator = shape_.separator;
    format.decimal_comma = shape_.decimal_comma;
    format.word = word_column;
    std::size_t whole = 0, single = 0;  // words that name a sensor, or one component
    for (const std::string& word : words) {
      whole += csv_name(word + "_x").name.empty() ? 0 : 1;
      single += csv_name(word).name.empty() ? 0 : 1;
    }
    if (std::max(whole, single) < 2) return false;
    header_of_a_word(word_column, words);
    const bool components = single > whole;
    std::vector<std::size_t> others;
    std::optional<std::size_t> time;
    for (std::size_t c = 0; c < numbers.size(); ++c) {
      if (2 * numbers[c] < rows[c]) continue;
      const std::string name = c < dialect_.names.size() ? dialect_.names[c] : "";
      if (!time && (dialect_.names.empty() || csv_name(name).name == "t")) {
        time = c;
      } else {
        others.push_back(c);
      }
    }
    const std::size_t values = components ? 1 : 3;
    // Without times, if there is a rate. Numbers alone without a name may be a time.
    if (dialect_.names.empty() && others.size() < values && time) {
      others.insert(others.begin(), *time);
      time.reset();
    }
    if (others.size() < values || (components && !time)) return false;
    std::vector<std::size_t> axes;
    for (const std::size_t c : others) {
      const std::string name = c < dialect_.names.size() ? dialect_.names[c] : "";
      if (!components && !csv_name("acc_" + name).name.empty()) axes.push_back(c);
    }
    const auto axis_of = [this](std::size_t c) {
      return csv_name("acc_" + dialect_.names[c]).name.back();
    };
    if (axes.size() == 3) std::ranges::sort(axes, {}, axis_of);  // "z,y,x" (Sensor Logger)
    format.time = time;
    format.values = axes.size() == 3 ? axes
                                     : std::vector<std::size_t>(
                                           others.end() - std::ptrdiff_t(values), others.end());
    std::vector<std::string> names, ignored;
    if (time) names.push_back(*time < dialect_.names.size() ? dialect_.names[*time] : "t");
    for (const std::string& word : words) {
      if (csv_name(components ? word : word + "_x").name.empty()) {
        ignored.push_back(quoted_text(word));
        continue;
      }
      format.words.push_back(word);
      for (std::size_t axis = 0; axis < values; ++axis) {
        names.push_back(components ? word : word + '_' + "xyz"[axis]);
      }
    }
    dialect_.notes.push_back(
        "every row is one sensor's: " + fmt::format("{}", fmt::join(format.words, ", ")) +
        (ignored.empty() ? "" : fmt::format("; ignored: {}", fmt::join(ignored, ", "))));
    dialect_.names = std::move(names);
    dialect_.one_sensor_a_line = !time;
    dialect_.header.clear();
    dialect_.separator = ',';
    dialect_.translator = long_format_translator(format);
    long_ = std::move(format);
    return true;
  }

  // Android's GnssLogger says behind '#' what the rows of a word hold:
  // # UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,...
  void header_of_a_word(std::size_t word_column, const std::vector<std::string>& words) {
    for (const HeadLine& line : lines_) {
      if (!is_comment(line.text)) continue;
      std::vector<std::string> fields =
          text_fields(without_comment_mark(line.text), shape_.separator);
      if (fields.size() < shape_.fields || fields.size() <= word_column) continue;
      const std::string word = fields[word_column];
      const bool sensor = !csv_name(word + "_x").name.empty();
      if (!sensor || std::ranges::find(words, word) == words.end()) continue;
      dialect_.names = std::move(fields);
      for (std::string& name : dialect_.names) {
        // Both are times; the elapsed one goes on while the other one is set.
        if (name == "elapsedRealtimeNanos") name = "time (ns)";
        if (name == "utcTimeMillis") name.clear();
        // "UncalAccelXMps2", and not "BiasXMps2"
        const std::string_view rest = std::string_view(name).substr(
            std::min(name.starts_with(word) ? word.size() : name.size(), name.size()));
        for (const char axis : {'X', 'Y', 'Z'}) {
          if (rest.starts_with(axis)) name = std::string(1, static_cast<char>(axis - 'X' + 'x'));
        }
      }
      return;
    }
  }

  // All rows of one sensor, then all of the next.
  bool one_sensor_after_the_other(const std::vector<HeadLine>& rows) const {
    std::vector<std::string> order;
    for (const HeadLine& row : rows) {
      const std::vector<std::string> fields = text_fields(row.text, shape_.separator);
      if (long_.word >= fields.size()) continue;
      const std::string& word = fields[long_.word];
      const bool known = std::ranges::find(long_.words, word) != long_.words.end();
      if (known && (order.empty() || order.back() != word)) order.push_back(word);
    }
    return long_.time && long_.values.size() == 3 && order.size() > 1 &&
           order.size() == long_.words.size();
  }

  // Their times go back where the next sensor begins, which is no clock that was set.
  void times_of_words() {
    const std::string time = dialect_.names.front();
    std::vector<std::string> names;
    for (std::size_t i = 0; i < long_.words.size(); ++i) {
      const std::string first = dialect_.names[1 + 3 * i], meaning = csv_name(first).name;
      const std::string own = long_.words[i] + " " + time;
      names.push_back(own);
      for (std::size_t axis = 0; axis < 3; ++axis)
        names.push_back(dialect_.names[1 + 3 * i + axis]);
      dialect_.times_of.emplace(meaning.substr(0, meaning.rfind('_')), own);
    }
    dialect_.names = std::move(names);
    long_.own_times = true;
    dialect_.translator = long_format_translator(long_);
  }

  const std::vector<HeadLine>&lines_, &elsewhere_;
  const TableShape& shape_;
  CsvDialect& dialect_;
  LongFormat long_;
};

}  // namespace

bool long_format_dialect(const std::vector<HeadLine>& lines, const std::vector<HeadLine>& elsewhere,
                         const TableShape& shape, CsvDialect& dialect) {
  return LongFormatFinder(lines, elsewhere, shape, dialect).find();
}

}  // namespace magimu
