// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/long_format_dialect.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/csv/columns/value_columns.h"
#include "recording/csv/columns/words.h"
#include "recording/data/quoted_text.h"
#include "recording/data/units.h"

namespace magimu {
namespace {

// Android's numbers of its sensors (Sensor.TYPE_...). Others, such as 9 for gravity, are passed
// over.
struct AndroidType {
  std::string_view number, word;
};
constexpr AndroidType kAndroidTypes[] = {
    {"1", "accelerometer"}, {"2", "magnetometer"},
    {"4", "gyroscope"},     {"14", "magnetometer_uncalibrated"},
    {"16", "gyro_uncal"},   {"35", "accelerometer_uncalibrated"}};

std::string android_word(const std::string& number) {
  const auto* const type = std::ranges::find(kAndroidTypes, number, &AndroidType::number);
  return std::string(type == std::end(kAndroidTypes) ? "" : type->word);
}

bool names_sensor(const std::string& word) { return !csv_name(word + "_x").name.empty(); }

class LongFormatFinder {
 public:
  LongFormatFinder(const std::vector<HeadLine>& lines, const std::vector<HeadLine>& elsewhere,
                   const TableShape& shape, const CsvOptions& options, CsvDialect& dialect)
      : lines_(lines), shape_(shape), options_(options), dialect_(dialect) {
    const auto add = [&](const HeadLine& row) {
      if (!is_comment(row.text)) rows_.push_back(text_fields(row.text, shape.separator));
    };
    std::for_each(lines.begin() + std::ptrdiff_t(shape.first_row), lines.end(), add);
    std::ranges::for_each(elsewhere, add);
  }

  bool find() {
    for (std::size_t c = 0; c < shape_.fields; ++c) {
      const std::vector<std::string> words = words_of(c);
      types_ = !words.empty() && is_type_of_sensor(c);
      if (words.empty() || !is_by(c, words)) continue;
      if (one_sensor_after_the_other()) times_of_words();
      return true;
    }
    return false;
  }

 private:
  // "sensorType", "sensor_type", "type", "sensor_id", above whole numbers: Android's.
  bool is_type_of_sensor(std::size_t column) const {
    const std::string words = plain_words(name_of(column));
    if (words.find("type") == std::string::npos && !words.starts_with("sensor")) return false;
    bool acc = false, gyr = false;
    for (const std::vector<std::string>& row : rows_) {
      if (column >= row.size()) continue;
      const std::string word = android_word(row[column]);
      if (word.empty() && (row[column].empty() ||
                           row[column].find_first_not_of("0123456789") != std::string::npos)) {
        return false;
      }
      acc = acc || word.starts_with("acc");
      gyr = gyr || word.starts_with("gyro");
    }
    return acc && gyr;
  }

  // The word that names the sensor.
  std::string meaning_of(const std::string& word) const {
    return types_ ? android_word(word) : word;
  }

  // The different words of a column without numbers, in their order.
  std::vector<std::string> words_of(std::size_t column) const {
    constexpr std::size_t kMostWords = 64;
    std::vector<std::string> words;
    for (const std::vector<std::string>& row : rows_) {
      if (column >= row.size()) continue;
      const FieldKind kind = field_kind(row[column]);
      if (kind == FieldKind::kEmpty) continue;
      if (kind != FieldKind::kWord && !is_type_of_sensor(column)) return {};
      if (words.size() < kMostWords && std::ranges::find(words, row[column]) == words.end()) {
        words.push_back(row[column]);
      }
    }
    return words;
  }

  // Whether the words of this column name what stands in their rows.
  bool is_by(std::size_t word_column, const std::vector<std::string>& words) {
    const auto whole = std::ranges::count_if(
        words, [this](const std::string& word) { return names_sensor(meaning_of(word)); });
    const auto single = std::ranges::count_if(words, [this](const std::string& word) {
      return !csv_name(meaning_of(word)).name.empty();
    });
    if (std::max(whole, single) < 2) return false;
    header_of_a_word(word_column, words);
    long_ = {};
    ignored_.clear();
    left_.clear();
    components_ = single > whole;
    long_.separator = shape_.separator;
    long_.decimal_comma = shape_.decimal_comma;
    long_.word = word_column;
    for (const std::string& word : words) {
      const std::string meaning = meaning_of(word);
      (csv_name(components_ ? meaning : meaning + "_x").name.empty() ? ignored_ : long_.words)
          .push_back(word);
    }
    if (!choose_columns(number_columns())) return false;
    name_columns();
    return true;
  }

  std::string name_of(std::size_t field) const {
    return field < dialect_.names.size() ? dialect_.names[field] : "";
  }

  double number(std::string text) const {
    if (shape_.decimal_comma) std::ranges::replace(text, ',', '.');
    const char* const first = text.data() + (text.starts_with('+') ? 1 : 0);
    double value = 0.0;
    std::from_chars(first, text.data() + text.size(), value);
    return value;
  }

  // A column that most rows have a number in. A position ("P" is a pressure as often) says nothing
  // about which columns the others have.
  std::vector<NumberColumn> number_columns() const {
    std::vector<std::string> sensors;
    std::ranges::copy_if(long_.words, std::back_inserter(sensors), [this](const std::string& word) {
      return !csv_name(meaning_of(word) + "_x").name.starts_with("pos");
    });
    std::vector<NumberColumn> columns;
    for (std::size_t c = 0; c < shape_.fields; ++c) {
      if (c == long_.word) continue;
      NumberColumn column{c, name_of(c), {}, true};
      column.of_sensor.resize(sensors.size());
      std::vector<std::size_t> rows_of(sensors.size(), 0);
      std::size_t numbers = 0, rows = 0;
      for (const std::vector<std::string>& row : rows_) {
        const FieldKind kind = c < row.size() ? field_kind(row[c]) : FieldKind::kEmpty;
        const bool is_number = kind != FieldKind::kEmpty && kind != FieldKind::kWord;
        rows += c < row.size() ? 1 : 0;
        numbers += is_number ? 1 : 0;
        if (long_.word >= row.size()) continue;
        const auto word = std::ranges::find(sensors, row[long_.word]);
        if (word == sensors.end()) continue;
        const auto sensor = static_cast<std::size_t>(word - sensors.begin());
        ++rows_of[sensor];
        if (!is_number) continue;
        // A time of the day is a number only to those who ask whether it falls.
        column.of_sensor[sensor].push_back(
            kind == FieldKind::kClock ? clock_seconds(row[c]).value_or(0.0) : number(row[c]));
      }
      if (2 * numbers < rows || numbers == 0) continue;
      for (std::size_t s = 0; s < sensors.size(); ++s) {
        if (2 * column.of_sensor[s].size() < rows_of[s]) column.every_sensor_has_it = false;
      }
      columns.push_back(std::move(column));
    }
    return columns;
  }

  static constexpr int kNoTime = -1000, kByOption = 1000;
  // How sure a column is the time, by its name.
  int claim_of(const NumberColumn& column) const {
    const auto given = options_.columns.find(column.name);
    if (given != options_.columns.end() && given->second == "t") return kByOption;
    const CsvName name = csv_name(column.name);
    return name.name == "t" ? name.preference : kNoTime;
  }

  bool choose_columns(std::vector<NumberColumn> columns) {
    const bool has_header = !dialect_.names.empty();
    const std::size_t values = components_ ? 1 : 3;
    auto time = columns.begin();
    if (has_header) {
      // The first of the surest.
      time = std::ranges::max_element(columns, {}, [this](const auto& c) { return claim_of(c); });
      if (time != columns.end() && claim_of(*time) == kNoTime) time = columns.end();
    } else if (columns.size() > values) {
      const auto clock = std::ranges::find_if(columns, is_clock_or_counter);
      if (clock != columns.end() || falls_as_readings_do(columns.front())) time = clock;
    }
    if (time != columns.end()) {
      long_.time = time->field;
      // Without times, if there is a rate. Numbers alone without a name may be a time.
      if (!has_header && columns.size() <= values) {
        long_.time.reset();
      } else {
        columns.erase(time);
      }
    }
    if (columns.size() < values || (components_ && !long_.time)) return false;
    long_.values = value_fields(columns, values);
    for (const NumberColumn& column : columns) {
      if (std::ranges::find(long_.values, column.field) == long_.values.end()) {
        left_.push_back(shown(column.field));
      }
    }
    return true;
  }

  // A column for people.
  std::string shown(std::size_t field) const {
    const std::string name = name_of(field);
    return name.empty() ? std::to_string(field + 1) : quoted_text(name);
  }

  // The unit that stands in a column of its own in all rows of a word.
  std::string unit_of(const std::string& word) const {
    const std::string meaning = meaning_of(word);
    std::string quantity = csv_name(components_ ? meaning : meaning + "_x").name;
    quantity.resize(std::min(quantity.find('_'), quantity.size()));
    for (std::size_t c = 0; c < shape_.fields; ++c) {
      if (c == long_.word || c == long_.time) continue;
      std::string unit;
      bool same = true;
      for (const std::vector<std::string>& row : rows_) {
        if (std::max(c, long_.word) >= row.size() || row[long_.word] != word) continue;
        same = same && (unit.empty() || unit == row[c]);
        unit = row[c];
      }
      const bool letters = field_kind(unit) == FieldKind::kWord;
      if (same && letters && unit_in_ours(quantity, unit)) return unit;
    }
    return "";
  }

  void name_columns() {
    std::vector<std::string> names, taken, ignored;
    for (const std::size_t field : long_.values) taken.push_back(shown(field));
    for (const std::string& word : ignored_) ignored.push_back(quoted_text(word));
    if (long_.time) names.push_back(name_of(*long_.time).empty() ? "t" : name_of(*long_.time));
    for (const std::string& word : long_.words) {
      const std::string meaning = meaning_of(word), unit = unit_of(word);
      for (std::size_t axis = 0; axis < long_.values.size(); ++axis) {
        names.push_back((components_ ? meaning : meaning + '_' + "xyz"[axis]) +
                        (unit.empty() ? "" : " (" + unit + ")"));
      }
    }
    dialect_.notes.push_back(
        "every row is one sensor's: " + fmt::format("{}", fmt::join(long_.words, ", ")) +
        (ignored.empty() ? "" : fmt::format("; ignored: {}", fmt::join(ignored, ", "))));
    if (!left_.empty()) {
      dialect_.notes.push_back(fmt::format(
          "of its columns of numbers {} {} read{}, not {}", fmt::join(taken, ", "),
          components_ ? "is" : "are", components_ ? "" : " as x, y, z", fmt::join(left_, ", ")));
    }
    if (components_) {
      for (const std::string& word : long_.words)
        long_.components.push_back(csv_name(meaning_of(word)).name);
    }
    dialect_.names = std::move(names);
    dialect_.one_sensor_a_line = !long_.time;
    dialect_.header.clear();
    dialect_.separator = ',';
    dialect_.translator = long_format_translator(long_);
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
      if (!names_sensor(word) || std::ranges::find(words, word) == words.end()) continue;
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
  bool one_sensor_after_the_other() const {
    std::vector<std::string> order;
    for (const std::vector<std::string>& row : rows_) {
      if (long_.word >= row.size()) continue;
      const std::string& word = row[long_.word];
      const bool known = std::ranges::find(long_.words, word) != long_.words.end();
      if (known && (order.empty() || order.back() != word)) order.push_back(word);
    }
    return long_.time && !components_ && order.size() > 1 && order.size() == long_.words.size();
  }

  // Their times go back where the next sensor begins, which is no clock that was set.
  void times_of_words() {
    const std::string time = dialect_.names.front();
    std::vector<std::string> names;
    std::map<std::string, int> claims;  // of several words for one sensor one is read
    for (std::size_t i = 0; i < long_.words.size(); ++i) {
      const std::string first = dialect_.names[1 + 3 * i],
                        own = meaning_of(long_.words[i]) + " " + time;
      names.push_back(own);
      for (std::size_t axis = 0; axis < 3; ++axis)
        names.push_back(dialect_.names[1 + 3 * i + axis]);
      const CsvName meaning = csv_name(first);
      const auto given = options_.columns.find(first);
      const bool by_option = given != options_.columns.end();
      const std::string& axis = by_option ? given->second : meaning.name;
      const std::string sensor = axis.substr(0, axis.rfind('_'));
      const int claim = by_option ? kByOption : meaning.preference;
      const auto [best, is_new] = claims.try_emplace(sensor, claim);
      if (!is_new && claim <= best->second) continue;
      best->second = claim;
      dialect_.times_of[sensor] = own;
    }
    dialect_.names = std::move(names);
    long_.own_times = true;
    dialect_.translator = long_format_translator(long_);
  }

  const std::vector<HeadLine>& lines_;
  const TableShape& shape_;
  const CsvOptions& options_;
  CsvDialect& dialect_;
  std::vector<std::vector<std::string>> rows_;  // fields of those that are looked at
  LongFormat long_;
  bool types_ = false;       // words are Android's numbers
  bool components_ = false;  // words name one component each ("acc_x"), not a sensor
  std::vector<std::string> ignored_, left_;  // words, columns of numbers
};

}  // namespace

bool long_format_dialect(const std::vector<HeadLine>& lines, const std::vector<HeadLine>& elsewhere,
                         const TableShape& shape, const CsvOptions& options, CsvDialect& dialect) {
  return LongFormatFinder(lines, elsewhere, shape, options, dialect).find();
}

}  // namespace magimu
