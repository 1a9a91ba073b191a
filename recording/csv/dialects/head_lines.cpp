// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/head_lines.h"

#include <algorithm>
#include <map>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/text_fields.h"

namespace magimu {
namespace {

constexpr std::size_t kSampleLines = 60;  // whose shape is looked at

struct LineShape {
  std::size_t fields = 0, numbers = 0, commas = 0, points = 0, words = 0;
  char group_mark = 0;
};

LineShape shape_of(std::string_view line, char separator) {
  LineShape shape;
  for (const std::string& field : text_fields(line, separator)) {
    ++shape.fields;
    const FieldKind kind = field_kind(field);
    if (const char mark = group_mark(field); mark != 0) shape.group_mark = mark;
    const bool comma = kind == FieldKind::kCommaNumber;
    // A decimal comma and the separator are never the same, but within quotation marks.
    if (kind == FieldKind::kNumber || comma) ++shape.numbers;
    if (comma) ++shape.commas;
    if (kind == FieldKind::kNumber && field.find('.') != std::string::npos) ++shape.points;
    if (kind == FieldKind::kWord) ++shape.words;
  }
  return shape;
}

bool is_row(const LineShape& line, std::size_t fields, std::size_t usual_numbers) {
  const bool as_many = line.fields + 1 >= fields && line.fields <= fields + 1;
  if (!as_many || line.numbers == 0) return false;
  return line.words == 0 || 2 * line.numbers >= usual_numbers;
}

// Whether a header follows soon: "Samples  100  100" above the names of the columns (LabVIEW) is no
// row, although it has as many numbers.
bool header_follows(const std::vector<HeadLine>& lines, std::size_t line, char separator,
                    std::size_t fields) {
  constexpr std::size_t kNear = 8;
  for (std::size_t i = line + 1; i < std::min(line + kNear, lines.size()); ++i) {
    const LineShape shape = shape_of(lines[i].text, separator);
    const bool as_many = shape.fields >= fields && shape.fields <= fields + 1;
    if (as_many && shape.words >= fields && !is_comment(lines[i].text)) return true;
  }
  return false;
}

// Whether a line names every field between tabs, also those that are empty in the rows (Xsens' UTC
// columns), which runs of blanks would swallow.
bool are_named_between_tabs(const std::vector<HeadLine>& lines,
                            const std::vector<std::string_view>& rows) {
  std::map<std::size_t, std::size_t> counts;
  for (const std::string_view row : rows) ++counts[text_fields(row, '\t').size()];
  if (counts.empty()) return false;
  const std::size_t fields =
      std::ranges::max_element(counts, {}, [](const auto& c) { return c.second; })->first;
  return fields > 1 && std::ranges::any_of(lines, [fields](const HeadLine& line) {
           std::vector<std::string> names = text_fields(without_comment_mark(line.text), '\t');
           if (names.back().empty()) names.pop_back();
           return (names.size() == fields || names.size() + 1 == fields) &&
                  std::ranges::all_of(names, [](const std::string& name) {
                    return field_kind(name) == FieldKind::kWord;
                  });
         });
}

TableShape shape_by(const std::vector<HeadLine>& lines, const std::vector<std::string_view>& sample,
                    std::string_view separators) {
  TableShape best;
  double best_score = 0.0;
  std::size_t usual_numbers = 0;
  for (const char separator : separators) {
    double score = 0.0;
    std::size_t commas = 0, points = 0, numbers = 0;
    char mark = 0;
    std::map<std::size_t, std::size_t> counts;
    for (const std::string_view line : sample) {
      const LineShape shape = shape_of(line, separator);
      if (shape.fields < 2) continue;
      score += double(shape.numbers * shape.numbers) / double(shape.fields);
      commas += shape.commas;
      points += shape.points;
      numbers += shape.numbers;
      if (shape.group_mark != 0) mark = shape.group_mark;
      ++counts[shape.fields];
    }
    if (score <= best_score) continue;
    best_score = score;
    best = {};
    best.separator = separator;
    best.decimal_comma = commas > 0 && (points == 0 || mark == '.');
    best.group_mark = mark;
    best.fields =
        std::ranges::max_element(counts, {}, [](const auto& c) { return c.second; })->first;
    usual_numbers = numbers / sample.size();
  }
  if (best.fields == 0) return best;
  best.empty_last = true;
  for (const std::string_view line : sample) {
    const std::vector<std::string> fields = text_fields(line, best.separator);
    if (fields.size() == best.fields && !fields.back().empty()) best.empty_last = false;
    const std::string_view blanks = best.separator == ' ' ? line : std::string_view();
    if (blanks.find("  ") != std::string_view::npos ||
        blanks.find('\t') != std::string_view::npos || blanks.starts_with(' ') ||
        blanks.ends_with(' ')) {
      best.single_blanks = false;
    }
    for (const std::size_t quote : {line.find('"')}) {
      if (quote == std::string_view::npos) continue;
      const std::string_view inside = line.substr(quote + 1, line.find('"', quote + 1) - quote - 1);
      best.quoted = best.quoted || field_kind(inside) != FieldKind::kWord;
    }
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (is_comment(lines[i].text)) continue;
    const LineShape line = shape_of(lines[i].text, best.separator);
    if (!is_row(line, best.fields, usual_numbers)) continue;
    if (line.words > 0 && header_follows(lines, i, best.separator, best.fields)) continue;
    best.first_row = i;
    return best;
  }
  return {};
}

}  // namespace

std::vector<HeadLine> head_lines(std::string_view head) {
  std::vector<HeadLine> lines;
  if (head.starts_with("\xEF\xBB\xBF")) head.remove_prefix(3);
  for (long number = 1; !head.empty(); ++number) {
    const std::size_t end = std::min(head.find('\n'), head.size());
    std::string_view text = head.substr(0, end);
    head.remove_prefix(std::min(end + 1, head.size()));
    while (text.ends_with('\r')) text.remove_suffix(1);
    if (!csv_trimmed(text).empty()) lines.push_back({text, number});
  }
  return lines;
}

bool is_comment(std::string_view text) {
  text = csv_trimmed(text);
  return text.starts_with('#') || text.starts_with("//");
}

std::string_view without_comment_mark(std::string_view text) {
  text = csv_trimmed(text);
  const std::size_t begin = std::min(text.find_first_not_of("#/%; \t"), text.size());
  const bool marked = is_comment(text) || text.starts_with("% ") || text.starts_with(";;");
  return marked ? text.substr(begin) : text;
}

TableShape table_shape(const std::vector<HeadLine>& lines) {
  // The last lines are rows, if anything is.
  std::vector<std::string_view> sample;
  const std::size_t least = lines.size() / 2;
  for (std::size_t i = lines.size(); i > least && sample.size() < kSampleLines; --i) {
    if (!is_comment(lines[i - 1].text)) sample.push_back(lines[i - 1].text);
  }
  const TableShape shape = shape_by(lines, sample, ",;\t| ");
  return shape.separator == ' ' && are_named_between_tabs(lines, sample)
             ? shape_by(lines, sample, "\t")
             : shape;
}

}  // namespace magimu
