// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/table_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/csv/columns/words.h"
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

// The fields of a line above the rows, if they are as many as those of the rows.
std::optional<std::vector<std::string>> header_fields(const std::vector<HeadLine>& lines,
                                                      const TableShape& shape, std::size_t line) {
  const std::string_view text = without_comment_mark(lines[line].text);
  std::vector<char> separators = {shape.separator, ',', ';', '\t', '|', ' '};
  for (const char separator : separators) {
    std::vector<std::string> fields = text_fields(text, separator);
    const bool words = std::ranges::any_of(
        fields, [](const std::string& f) { return field_kind(f) == FieldKind::kWord; });
    if (!words || fields.size() < 2) continue;
    if (fields.size() == shape.fields) return fields;
    if (fields.size() == shape.fields + 1 && fields.back().empty()) {
      fields.pop_back();  // that column never has a field
      return fields;
    }
    if (fields.size() == shape.fields + 1 && separator == shape.separator &&
        csv_name(fields.back()).name.empty() && !csv_name(fields.front()).name.empty()) {
      fields.pop_back();  // nothing is in it, and no separator before it ("Comment" of LabVIEW)
      return fields;
    }
    if (fields.size() + 1 == shape.fields && shape.empty_last) {
      fields.emplace_back();
      return fields;
    }
    // R writes no name for the rows' own names.
    if (fields.size() + 1 == shape.fields && separator == shape.separator &&
        field_kind(text_fields(lines[shape.first_row].text, separator).front()) ==
            FieldKind::kWord) {
      fields.insert(fields.begin(), "");
      return fields;
    }
  }
  return std::nullopt;
}

std::vector<std::string> with_units(std::vector<std::string> names,
                                    const std::vector<std::string>& units) {
  for (std::size_t i = 0; i < names.size() && i < units.size(); ++i) {
    std::string unit = units[i];
    std::erase_if(unit, [](char c) { return c == '(' || c == ')' || c == '[' || c == ']'; });
    if (!unit.empty() && unit != "-") names[i] += " (" + unit + ")";
  }
  return names;
}

// A sensor's name stands above the first of its axes.
std::vector<std::string> with_groups(const std::vector<std::string>& groups,
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

// pandas writes the names of a table's index into a line of their own, below those of the columns.
bool names_index(const std::vector<std::string>& fields) {
  return fields.size() > 2 && !fields.front().empty() &&
         std::all_of(fields.begin() + 1, fields.end(), [](const auto& f) { return f.empty(); });
}

// Columns of several levels (a MultiIndex of pandas): a line each, in every one of which all
// columns have a name. Above the index stand the levels' names, or nothing.
std::optional<TableHeader> levels_header(const std::vector<HeadLine>& lines,
                                         const TableShape& shape, const CsvOptions& options) {
  constexpr std::size_t kMostLevels = 4;
  std::size_t line = shape.first_row;
  std::optional<std::vector<std::string>> names, index;
  if (line > 0) index = header_fields(lines, shape, line - 1);
  if (index && names_index(*index)) {
    --line;
  } else {
    index.reset();
  }
  std::size_t levels = 0;
  for (; line > 0 && levels < kMostLevels; --line, ++levels) {
    auto level = header_fields(lines, shape, line - 1);
    const auto is_empty = [](const std::string& field) { return field.empty(); };
    if (!level || std::any_of(level->begin() + 1, level->end(), is_empty)) break;
    if (!names && are_units(*level)) break;
    names = names ? with_groups(*level, std::move(*names)) : std::move(*level);
  }
  if (!names || levels < 2) return std::nullopt;
  std::string& first = names->front();
  if (index) first = index->front();
  if (csv_name(first).name.empty() && csv_time_of(first).empty() &&
      !options.columns.contains(first)) {
    first.clear();  // a name of the index, or those of the levels, that says nothing
  }
  const std::size_t rows = shape.first_row - line;
  return TableHeader{*std::move(names), line, rows, rows};
}

}  // namespace

std::optional<TableHeader> table_header(const std::vector<HeadLine>& lines, const TableShape& shape,
                                        const CsvOptions& options) {
  std::size_t best_score = 0, above = shape.first_row;
  std::optional<TableHeader> best;
  const auto consider = [&](std::vector<std::string> names, std::size_t line, std::size_t rows) {
    const std::size_t score = named_quantities(names, options);
    if (best && score <= best_score) return;
    best_score = score;
    best = TableHeader{std::move(names), line, rows};
  };
  if (above == 0) return best;
  const auto lower = header_fields(lines, shape, above - 1);
  const auto upper = above > 1 ? header_fields(lines, shape, above - 2) : std::nullopt;
  if (lower) consider(*lower, above - 1, 1);
  if (upper && lower) {
    if (are_units(*lower)) consider(with_units(*upper, *lower), above - 2, 2);
    consider(with_groups(*upper, *lower), above - 2, 2);
  }
  if (upper) consider(*upper, above - 2, 2);
  if (auto levels = levels_header(lines, shape, options)) {
    // The index is a time by its place only.
    if (named_quantities(levels->names, options) >= best_score) return levels;
  }
  // A header that something stands below: another line that names more.
  constexpr std::size_t kFar = 6;
  for (std::size_t up = 3; up <= above && up <= kFar && best_score < 4; ++up) {
    if (const auto other = header_fields(lines, shape, above - up))
      consider(*other, above - up, up);
  }
  return best;
}

}  // namespace magimu
