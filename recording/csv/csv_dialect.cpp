// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/csv_dialect.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "recording/csv/checksum_lines.h"
#include "recording/csv/csv_columns.h"
#include "recording/csv/csv_names.h"
#include "recording/csv/head_lines.h"
#include "recording/csv/labelled_dialect.h"
#include "recording/csv/long_format_dialect.h"
#include "recording/csv/stamped_lines.h"
#include "recording/csv/teleplot.h"
#include "recording/csv/text_fields.h"
#include "recording/csv/words.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/units.h"

namespace magimu {
namespace {

// How many quantities of ours these headers name.
std::size_t named_quantities(const std::vector<std::string>& headers, const CsvOptions& options) {
  std::set<std::string> names;
  for (const std::string& header : with_axes_for_numbers(headers)) {
    const auto given = options.columns.find(header);
    if (given != options.columns.end()) names.insert(given->second);
    for (const std::string& text : {header, options.sensor + '_' + header}) {
      if (const std::string name = csv_name(text).name; !name.empty()) names.insert(name);
    }
    if (!csv_time_of(header).empty()) names.insert(header);
  }
  return names.size();
}

bool is_unit(const std::string& text) {
  std::string bare = text;
  std::erase_if(bare, [](char c) { return c == '(' || c == ')' || c == '[' || c == ']'; });
  if (bare.empty() || bare == "-") return true;
  return std::ranges::any_of(std::initializer_list<const char*>{"t", "acc", "gyr", "mag"},
                             [&](const char* q) { return unit_in_ours(q, bare).has_value(); });
}

// Most of them: a few may be words of the logger's own ("local_flux").
bool are_units(const std::vector<std::string>& fields) {
  const auto known = std::ranges::count_if(fields, is_unit);
  const bool numbers = std::ranges::any_of(
      fields, [](const std::string& f) { return field_kind(f) == FieldKind::kNumber; });
  return !numbers && 3 * static_cast<std::size_t>(known) >= 2 * fields.size();
}

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
      // A first line of words that does not fit the rows: the fast reader says how.
      if (shape_.first_row > 0 && !stamped_ && !is_comment(lines_.front().text)) return {};
      no_header();
    } else if (long_format()) {
      return with_stamps();
    }
    name_index();
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

  // The terminal's clock before each line, if there is one: the time where there is no other.
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

  // The fields of a line above the rows, if they are as many as those of the rows.
  std::optional<std::vector<std::string>> header_fields(std::size_t line) const {
    const std::string_view text = without_comment_mark(lines_[line].text);
    std::vector<char> separators = {shape_.separator, ',', ';', '\t', '|', ' '};
    for (const char separator : separators) {
      std::vector<std::string> fields = text_fields(text, separator);
      const bool words = std::ranges::any_of(
          fields, [](const std::string& f) { return field_kind(f) == FieldKind::kWord; });
      if (!words || fields.size() < 2) continue;
      if (fields.size() == shape_.fields) return fields;
      if (fields.size() == shape_.fields + 1 && fields.back().empty()) {
        fields.pop_back();  // that column never has a field
        return fields;
      }
      if (fields.size() + 1 == shape_.fields && shape_.empty_last) {
        fields.emplace_back();
        return fields;
      }
      // R writes no name for the rows' own names.
      if (fields.size() + 1 == shape_.fields && separator == shape_.separator &&
          field_kind(text_fields(lines_[shape_.first_row].text, separator).front()) ==
              FieldKind::kWord) {
        fields.insert(fields.begin(), "");
        return fields;
      }
    }
    return std::nullopt;
  }

  // One row or two, with units in one of them: whatever names most of what we know.
  bool find_header() {
    std::size_t best_score = 0, above = shape_.first_row;
    bool found = false;
    const auto consider = [&](std::vector<std::string> names, std::size_t line, std::size_t rows) {
      const std::size_t score = named_quantities(names, options_);
      if (found && score <= best_score) return;
      found = true;
      best_score = score;
      dialect_.names = std::move(names);
      dialect_.header_line = lines_[line].number;
      dialect_.header = std::string(csv_trimmed(lines_[line].text));
      header_rows_ = rows;
    };
    if (above == 0) return false;
    const auto lower = header_fields(above - 1);
    const auto upper = above > 1 ? header_fields(above - 2) : std::nullopt;
    if (lower) consider(*lower, above - 1, 1);
    if (upper && lower) {
      if (are_units(*lower)) consider(with_units(*upper, *lower), above - 2, 2);
      consider(with_groups(*upper, *lower), above - 2, 2);
    }
    if (upper) consider(*upper, above - 2, 2);
    // A header that something stands below: another line that names more.
    constexpr std::size_t kFar = 6;
    for (std::size_t up = 3; up <= above && up <= kFar && best_score < 4; ++up) {
      if (const auto other = header_fields(above - up)) consider(*other, above - up, up);
    }
    return found;
  }

  static std::vector<std::string> with_units(std::vector<std::string> names,
                                             const std::vector<std::string>& units) {
    for (std::size_t i = 0; i < names.size() && i < units.size(); ++i) {
      std::string unit = units[i];
      std::erase_if(unit, [](char c) { return c == '(' || c == ')' || c == '[' || c == ']'; });
      if (!unit.empty() && unit != "-") names[i] += " (" + unit + ")";
    }
    return names;
  }

  // A sensor's name stands above the first of its axes.
  static std::vector<std::string> with_groups(const std::vector<std::string>& groups,
                                              std::vector<std::string> names) {
    std::string group;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (i < groups.size() && !groups[i].empty()) group = groups[i];
      // The group's unit goes behind the axis.
      const std::size_t bracket = std::min(group.find_first_of("(["), group.size());
      const std::string_view word = csv_trimmed(std::string_view(group).substr(0, bracket));
      if (names[i].empty()) {
        names[i] = group;
      } else if (!group.empty()) {
        const bool has_unit = names[i].find_first_of("([") != std::string::npos;
        names[i] =
            fmt::format("{} {}{}", word, names[i],
                        has_unit || bracket == group.size() ? "" : " " + group.substr(bracket));
      }
    }
    return names;
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
    throw InputError(
        file_, dialect_.first_row, 0,
        fmt::format("there is no header: the first line holds numbers, not the names of the "
                    "columns ({} of them)",
                    shape_.fields),
        "put a header line above it, or name the columns (- ignores one): --columns "
        "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z");
  }

  bool long_format() {
    return options_.header.empty() &&
           long_format_dialect(lines_, elsewhere_, shape_, options_, dialect_);
  }

  // pandas writes no name above its index, which is the time where no other column is.
  void name_index() {
    if (dialect_.header_line == 0 || dialect_.names.empty() || !dialect_.names.front().empty()) {
      return;
    }
    const bool has_time = std::ranges::any_of(dialect_.names, [this](const std::string& name) {
      const auto given = options_.columns.find(name);
      return (given != options_.columns.end() && given->second == "t") ||
             csv_name(name).name == "t" || !csv_time_of(name).empty();
    });
    const FieldKind kind =
        field_kind(text_fields(lines_[shape_.first_row].text, shape_.separator).front());
    if (!has_time && kind != FieldKind::kEmpty && kind != FieldKind::kWord) {
      dialect_.names.front() = "t";
      dialect_.notes.emplace_back("the first column has no name: it is read as t");
    }
  }

  // Columns "acc_time", "gyr_time": one each for two sensors or more.
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

  // The column whose name ends so, in lower case; as many as there are if there is none.
  std::size_t column(std::initializer_list<const char*> ends) const {
    for (std::size_t i = 0; i < dialect_.names.size(); ++i) {
      std::string name = plain_words(dialect_.names[i]);
      std::ranges::replace_if(
          name, [](char c) { return c == '.' || c == '/' || c == ' '; }, '_');
      for (const std::string end : ends) {
        if (name == end || name.ends_with("_" + end)) return i;
      }
    }
    return dialect_.names.size();
  }

  // Seconds, and behind them what is beyond them in ns, us or ms.
  bool fraction_of_seconds() {
    const std::size_t s = column({"sec", "secs", "seconds"});
    if (s == dialect_.names.size() || shape_.separator == ' ') return false;
    const std::pair<std::size_t, std::size_t> fractions[] = {
        {column({"nsec", "nsecs", "nanosec", "nanosecs"}), 9},
        {column({"usec", "usecs", "microseconds"}), 6},
        {column({"msec", "msecs", "milliseconds"}), 3}};
    for (const auto& [fraction, digits] : fractions) {
      if (fraction != s + 1 || fraction == dialect_.names.size()) continue;
      if (digits < 9 && !begins_anew_each_second(s, fraction, digits)) continue;
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

  // Milliseconds beside seconds may be all of the time once more.
  bool begins_anew_each_second(std::size_t s, std::size_t fraction, std::size_t digits) const {
    std::string second, before;
    std::size_t anew = 0;
    for (std::size_t i = shape_.first_row; i < lines_.size(); ++i) {
      const std::vector<std::string> fields = text_fields(lines_[i].text, shape_.separator);
      if (fields.size() <= fraction) continue;
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

  // What the fast reader does by itself: the first line that is no comment is the header.
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
      said.push_back(header_rows_ == 2 &&
                             lines_[shape_.first_row - 1].number != dialect_.header_line
                         ? fmt::format("names are in lines {} and {}", dialect_.header_line,
                                       lines_[shape_.first_row - 1].number)
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
