// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/csv_dialect.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/old_charset.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/csv/columns/value_columns.h"
#include "recording/csv/columns/words.h"
#include "recording/csv/dialects/checksum_lines.h"
#include "recording/csv/dialects/head_lines.h"
#include "recording/csv/dialects/labelled_dialect.h"
#include "recording/csv/dialects/long_format_dialect.h"
#include "recording/csv/dialects/stamped_lines.h"
#include "recording/csv/dialects/table_header.h"
#include "recording/csv/dialects/teleplot.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/units.h"

namespace magimu {
namespace {

class Recogniser {
 public:
  Recogniser(std::string_view head, std::string_view elsewhere, const std::string& file,
             const CsvOptions& options)
      : lines_(head_lines(head)),
        elsewhere_(head_lines(elsewhere)),
        file_(file),
        options_(options) {}

  CsvDialect recognised() {
    if (std::optional<CsvDialect> teleplot = teleplot_dialect(lines_, options_)) {
      return *std::move(teleplot);
    }
    if (std::optional<CsvDialect> labelled = labelled_dialect(lines_, options_)) {
      return *std::move(labelled);
    }
    stamped_ = take_stamps(lines_);
    checksums_ = take_checksums(lines_);
    shape_ = table_shape(lines_);
    if (shape_.fields == 0) return {};
    dialect_.separator = shape_.separator;
    dialect_.first_row = lines_[shape_.first_row].number;
    const bool header = find_header();
    if (!options_.header.empty()) {
      given_header();
    } else if (!header && checksums_ && checksums_->names.size() == shape_.fields) {
      dialect_.names = checksums_->names;
    } else if (!header) {
      if (long_format()) return with_stamps();
      if (axes_without_header()) {
        translate();
        say();
        return with_stamps();
      }
      // The first line holds words but does not fit the rows: CsvParser will name the error.
      if (shape_.first_row > 0 && !stamped_ && !is_comment(lines_.front().text)) return {};
      no_header();
    } else if (long_format()) {
      return with_stamps();
    }
    name_index();
    time_before_each_column();
    time_of_another_name();
    own_times();
    translate();
    if (is_plain()) return {};
    say();
    return with_stamps();
  }

 private:
  // Lines in the manner of NMEA are rows once the checksum is taken from them.
  void without_checksums() {
    if (!checksums_) return;
    dialect_.notes.insert(dialect_.notes.begin(), checksums_->notes.begin(),
                          checksums_->notes.end());
    dialect_.translator =
        checksum_translator(*std::move(checksums_), std::move(dialect_.translator));
  }

  // Adds the clock that a terminal wrote before each line: it is the time if there is no other.
  CsvDialect with_stamps() {
    without_checksums();
    if (!stamped_) return std::move(dialect_);
    const bool has_time = std::ranges::any_of(dialect_.names, [this](const std::string& name) {
      const auto given = options_.columns.find(name);
      return given != options_.columns.end() ? given->second == "t" : csv_name(name).name == "t";
    });
    StampedLines lines{std::move(dialect_.translator), !clock_name_.empty() || !has_time,
                       dialect_.separator, dialect_.header};
    if (lines.with_clock) {
      dialect_.names.insert(dialect_.names.begin(), clock_name_.empty() ? "time" : clock_name_);
    }
    dialect_.notes.push_back(fmt::format("a terminal's clock is before each line: it is {}",
                                         lines.with_clock ? "the time" : "not used"));
    dialect_.translator = stamped_translator(std::move(lines));
    return std::move(dialect_);
  }

  bool find_header() {
    std::optional<TableHeader> found = table_header(lines_, shape_, options_);
    if (!found) return false;
    std::string charset;
    dialect_.names = names_in_utf8(found->names, charset);
    if (!charset.empty()) {
      dialect_.notes.push_back(fmt::format("the header is in {}, not in UTF-8", charset));
    }
    dialect_.header_line = lines_[found->line].number;
    dialect_.header = std::string(csv_trimmed(lines_[found->line].text));
    header_rows_ = found->rows;
    several_levels_ = found->levels > 2;
    return true;
  }

  void given_header() {
    dialect_.names = text_fields(options_.header, ',');
    dialect_.header_line = 0;
    dialect_.header.clear();
    header_rows_ = 0;
    if (stamped_ && dialect_.names.size() == shape_.fields + 1) {  // the clock has a name, too
      clock_name_ = dialect_.names.front();
      dialect_.names.erase(dialect_.names.begin());
    }
    if (dialect_.names.size() + 1 == shape_.fields && shape_.empty_last) {
      dialect_.names.emplace_back();
    }
    if (dialect_.names.size() == shape_.fields) return;
    throw InputError(file_, dialect_.first_row, 0,
                     fmt::format("--columns names {} columns, this row has {} fields",
                                 dialect_.names.size(), shape_.fields),
                     "name every column in its order; - ignores one");
  }

  [[noreturn]] void no_header() const {
    // MissingSensor: it may be one of several files, whose name says the sensor.
    throw MissingSensor(
        file_, dialect_.first_row, 0,
        fmt::format("there is no header: the first line holds numbers, not the names of the "
                    "columns ({} of them)",
                    shape_.fields),
        std::string("put a header line above it, or name the columns (- ignores one): --columns ") +
            (options_.sensor.empty() ? "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z"
                                     : "t,x,y,z"));
  }

  bool long_format() {
    return options_.header.empty() &&
           long_format_dialect(lines_, elsewhere_, shape_, options_, dialect_);
  }

  bool has_time() const {
    return std::ranges::any_of(dialect_.names, [this](const std::string& name) {
      const auto given = options_.columns.find(name);
      return (given != options_.columns.end() && given->second == "t") ||
             csv_name(name).name == "t" || !csv_time_of(name).empty();
    });
  }

  // The fields of a column, of the first rows.
  std::vector<std::string> fields_of(std::size_t column) const {
    std::vector<std::string> out;
    for (std::size_t i = shape_.first_row; i < lines_.size(); ++i) {
      if (is_comment(lines_[i].text)) continue;
      std::vector<std::string> fields = text_fields(lines_[i].text, shape_.separator);
      if (column < fields.size()) out.push_back(std::move(fields[column]));
    }
    return out;
  }

  bool never_falls(std::size_t column) const {
    NumberColumn numbers{column, "", std::vector<std::vector<double>>(1), true};
    for (std::string text : fields_of(column)) {
      if (shape_.decimal_comma) std::ranges::replace(text, ',', '.');
      double value = 0.0;
      const char* const end = text.data() + text.size();
      if (std::from_chars(text.data(), end, value).ptr == end && !text.empty()) {
        numbers.of_sensor.front().push_back(value);
      }
    }
    return is_clock_or_counter(numbers);
  }

  // The time has a name that says nothing to us: the first column of times of the day or dates;
  // else of those whose numbers never fall the first whose header has a unit of time, or whose name
  // ends with "time".
  void time_of_another_name() {
    if (dialect_.header_line == 0 || has_time() || options_.rate_hz) return;
    const auto take = [this](std::size_t i, const std::string& name, const char* why) {
      dialect_.notes.push_back(
          fmt::format("column {} is the time: {}", quoted_text(dialect_.names[i]), why));
      dialect_.names[i] = name;
    };
    for (std::size_t i = 0; i < dialect_.names.size(); ++i) {
      const std::vector<std::string> fields = fields_of(i);
      const bool clock = std::ranges::all_of(
          fields, [](const std::string& field) { return clock_seconds(field).has_value(); });
      if (clock && !fields.empty()) return take(i, "t", "it holds times of the day");
    }
    for (const bool by_unit : {true, false}) {
      for (std::size_t i = 0; i < dialect_.names.size(); ++i) {
        const std::string words = plain_words(dialect_.names[i]);
        const std::string unit = time_unit_of(dialect_.names[i]);
        const bool named = by_unit ? !unit.empty() : words.ends_with("time");
        if (!named || !csv_name(dialect_.names[i]).name.empty() || !never_falls(i)) continue;
        return take(i, by_unit ? "t (" + unit + ")" : "t",
                    by_unit ? "its unit is one, and it never falls" : "it never falls");
      }
    }
  }

  // "ms" of "timeCntr (ms)"; empty where no unit of time is in brackets.
  static std::string time_unit_of(const std::string& name) {
    const std::size_t open = name.find_last_of("([");
    if (open == std::string::npos || name.size() < open + 3) return "";
    const std::string unit = name.substr(open + 1, name.size() - open - 2);
    return field_kind(unit) == FieldKind::kWord && unit_in_ours("t", unit) ? unit : "";
  }

  // Of the file of one sensor, as its name says: one column is a clock, the other three are axes.
  bool axes_without_header() {
    if (options_.sensor.empty() || shape_.fields != 4) return false;
    std::vector<std::size_t> clocks;
    for (std::size_t i = 0; i < shape_.fields; ++i) {
      if (never_falls(i)) clocks.push_back(i);
    }
    if (clocks.size() != 1) return false;
    std::size_t axis = 0;
    for (std::size_t i = 0; i < shape_.fields; ++i) {
      dialect_.names.emplace_back(i == clocks.front() ? std::string("t")
                                                      : std::string(1, "xyz"[axis++]));
    }
    dialect_.header_line = 0;
    dialect_.notes.push_back(fmt::format(
        "there is no header: column {}, which never falls, is the time, the others are x, y, z",
        clocks.front() + 1));
    return true;
  }

  // A time before every column, with the same name each (Delsys: "X[s]"): that before the first
  // axis of a sensor is the sensor's.
  void time_before_each_column() {
    std::map<std::string, std::size_t> count;
    for (const std::string& name : dialect_.names) ++count[name];
    for (const auto& [name, times] : count) {
      const std::string unit = time_unit_of(name);
      const bool is_time = csv_name(name).name == "t" || !unit.empty();
      if (times < 3 || !is_time) continue;
      std::set<std::string> seen;
      for (std::size_t i = 0; i + 1 < dialect_.names.size(); ++i) {
        if (dialect_.names[i] != name) continue;
        const std::string meaning = csv_name(dialect_.names[i + 1]).name;
        std::string sensor = meaning.substr(0, meaning.find('_'));
        if (sensor.starts_with("mag")) sensor = "mag";
        const bool first = !sensor.empty() && sensor != "t" && seen.insert(sensor).second;
        dialect_.names[i] =
            first ? fmt::format("{} time{}", sensor, unit.empty() ? "" : " (" + unit + ")") : "";
      }
      if (dialect_.names.back() == name) dialect_.names.back().clear();
      return;
    }
  }

  // pandas writes no name above its index, which is the time where no other column is.
  void name_index() {
    if (dialect_.header_line == 0 || dialect_.names.empty() || !dialect_.names.front().empty()) {
      return;
    }
    const FieldKind kind =
        field_kind(text_fields(lines_[shape_.first_row].text, shape_.separator).front());
    if (!has_time() && kind != FieldKind::kEmpty && kind != FieldKind::kWord) {
      dialect_.names.front() = "t";
      dialect_.notes.emplace_back("the first column has no name: it is read as t");
    }
  }

  // Finds columns "acc_time", "gyr_time", ... if two sensors or more have one.
  void own_times() {
    std::map<std::string, std::string> times;
    for (const std::string& name : dialect_.names) {
      if (const CsvName other = csv_name(name); !other.name.empty() && other.preference >= 0)
        continue;
      if (const std::string sensor = csv_time_of(name); !sensor.empty())
        times.emplace(sensor, name);
    }
    if (times.size() >= 2) dialect_.times_of = std::move(times);
  }

  // The first column whose name, in lower case, ends with one of these; the number of columns if
  // there is none.
  std::size_t column(std::initializer_list<const char*> ends) const {
    for (std::size_t i = 0; i < dialect_.names.size(); ++i) {
      std::string name = plain_words(dialect_.names[i]);
      name.resize(std::min(name.find_first_of("(["), name.size()));
      while (name.ends_with(' ')) name.pop_back();
      std::ranges::replace_if(
          name, [](char c) { return c == '.' || c == '/' || c == ' '; }, '_');
      for (const std::string end : ends) {
        if (name == end || name.ends_with("_" + end)) return i;
      }
    }
    return dialect_.names.size();
  }

  // Whether the time stands in two columns, seconds and their fraction in ns, us or ms: then they
  // become one.
  bool fraction_of_seconds() {
    if (shape_.separator == ' ') return false;
    const std::size_t named = column({"sec", "secs", "seconds"});
    const std::pair<std::size_t, std::size_t> fractions[] = {
        {column({"nsec", "nsecs", "nanosec", "nanosecs", "nanoseconds", "ns"}), 9},
        {column({"usec", "usecs", "microsec", "microseconds", "us"}), 6},
        {column({"msec", "msecs", "millisec", "milliseconds", "ms"}), 3}};
    for (const auto& [fraction, digits] : fractions) {
      if (fraction == dialect_.names.size() || fraction == 0) continue;
      const std::size_t s = fraction - 1;
      // "Unix Time", "Microseconds"
      if (s != named && csv_name(dialect_.names[s]).name != "t") continue;
      const bool of_ros = s == named && digits == 9;
      if (!of_ros && !begins_anew_each_second(s, fraction, digits)) continue;
      dialect_.translator = fraction_translator(shape_.separator, s, fraction, digits);
      dialect_.notes.push_back(fmt::format("the time is {} and {} together",
                                           quoted_text(dialect_.names[s]),
                                           quoted_text(dialect_.names[fraction])));
      dialect_.names[s] = "header stamp (s)";
      dialect_.names[fraction].clear();
      return true;
    }
    return false;
  }

  // Whether the second column begins anew with each second. (A column of ms or us beside one of
  // seconds may also hold the whole time again.)
  bool begins_anew_each_second(std::size_t s, std::size_t fraction, std::size_t digits) const {
    std::string second, before;
    std::size_t anew = 0;
    for (std::size_t i = shape_.first_row; i < lines_.size(); ++i) {
      const std::vector<std::string> fields = text_fields(lines_[i].text, shape_.separator);
      if (fields.size() <= fraction) continue;
      if (fields[s].find_first_not_of("0123456789") != std::string::npos) return false;
      if (fields[fraction].size() > digits ||
          fields[fraction].find_first_not_of("0123456789") != std::string::npos) {
        return false;
      }
      const std::string padded(digits - fields[fraction].size(), '0');
      const std::string now = padded + fields[fraction];
      if (now < before && fields[s] == second) return false;
      anew += now < before ? 1 : 0;
      second = fields[s];
      before = now;
    }
    return anew > 0;
  }

  void translate() {
    if (fraction_of_seconds()) return;
    const bool blanks = shape_.separator == ' ' && !shape_.single_blanks;
    if (shape_.decimal_comma || blanks || shape_.quoted || shape_.group_mark != 0) {
      dialect_.translator =
          plain_numbers_translator(shape_.separator, shape_.decimal_comma, shape_.group_mark);
    }
  }

  // Whether CsvParser can read the file without a dialect: its first line that is no comment is the
  // header.
  bool is_plain() const {
    if (stamped_ || checksums_ || dialect_.translator || !dialect_.times_of.empty() ||
        header_rows_ != 1)
      return false;
    const auto first = std::ranges::find_if(
        lines_, [](const HeadLine& l) { return !csv_trimmed(l.text).starts_with('#'); });
    if (first == lines_.end() || first->number != dialect_.header_line) return false;
    char separator = ',';
    for (const char c : {'\t', ';', ','}) {
      if (first->text.find(c) != std::string_view::npos) separator = c;
    }
    return separator == shape_.separator && text_fields(first->text, separator) == dialect_.names &&
           !shape_.empty_last;
  }

  void say() {
    std::vector<std::string> said;
    const char* const name = shape_.separator == ';'    ? "semicolons"
                             : shape_.separator == '\t' ? "tabs"
                             : shape_.separator == '|'  ? "bars"
                             : shape_.separator == ' '  ? "blanks"
                                                        : "commas";
    said.push_back(fmt::format("fields are separated by {}", name));
    if (shape_.decimal_comma) said.emplace_back("decimals by a comma");
    if (dialect_.header_line > 0) {
      const long last = lines_[shape_.first_row - 1].number;
      said.push_back(header_rows_ == 2 && last != dialect_.header_line
                         ? fmt::format("names are in lines {} and {}", dialect_.header_line, last)
                     : several_levels_
                         ? fmt::format("names are in lines {} to {}", dialect_.header_line, last)
                         : fmt::format("names are in line {}", dialect_.header_line));
    }
    said.push_back(fmt::format("rows begin in line {}", dialect_.first_row));
    dialect_.notes.push_back(fmt::format("{}", fmt::join(said, ", ")));
  }

  std::vector<HeadLine> lines_;
  std::vector<HeadLine> elsewhere_;  // lines from the rest of the file; their numbers mean nothing
  const std::string& file_;
  const CsvOptions& options_;
  TableShape shape_;
  CsvDialect dialect_;
  std::size_t header_rows_ = 0;
  bool several_levels_ = false;             // all of those rows hold names
  std::optional<ChecksumLines> checksums_;  // lines_ are without them
  bool stamped_ = false;    // lines_ are without the clock that a terminal put before them
  std::string clock_name_;  // given to it by an option
};

}  // namespace

CsvDialect recognised_dialect(std::string_view head, const std::string& file,
                              const CsvOptions& options, std::string_view elsewhere) {
  return Recogniser(head, elsewhere, file, options).recognised();
}

}  // namespace magimu
