// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/stamped_lines.h"

#include <algorithm>
#include <utility>

#include "recording/csv/columns/csv_columns.h"

namespace magimu {
namespace {

class Stamped final : public LineTranslator {
 public:
  explicit Stamped(StampedLines lines) : lines_(std::move(lines)) {}

  std::optional<std::string_view> row(std::string_view line) override {
    const std::optional<std::string_view> clock = take_stamp(line);
    if (csv_trimmed(line).empty() || csv_trimmed(line) == lines_.header) return std::nullopt;
    const std::optional<std::string_view> row = lines_.inner ? lines_.inner->row(line) : line;
    if (!row || !lines_.with_clock) return row;
    out_ = clock.value_or(std::string_view());
    std::ranges::replace(out_, ' ', 'T');  // of a date and a time
    out_ += lines_.separator;
    out_ += *row;
    return out_;
  }

 private:
  StampedLines lines_;
  std::string out_;
};

}  // namespace

std::optional<std::string_view> take_stamp(std::string_view& line) {
  std::string_view rest = line;
  const std::optional<std::string_view> clock = leading_clock(rest);
  if (!clock) return std::nullopt;
  // A clock followed by a separator is a field of a table.
  const std::string_view between = line.substr(0, line.size() - rest.size());
  const bool arrow = between.find("->") != std::string_view::npos;
  const bool brackets = csv_trimmed(between).starts_with('[') && between.find(']') != between.npos;
  if (!arrow && !brackets) return std::nullopt;
  line = rest;
  return clock;
}

bool take_stamps(std::vector<HeadLine>& lines) {
  std::vector<HeadLine> without;
  std::size_t stamped = 0;
  for (HeadLine line : lines) {
    stamped += take_stamp(line.text) ? 1 : 0;
    if (!csv_trimmed(line.text).empty()) without.push_back(line);
  }
  if (2 * stamped <= lines.size()) return false;
  lines = std::move(without);
  return true;
}

std::shared_ptr<LineTranslator> stamped_translator(StampedLines lines) {
  return std::make_shared<Stamped>(std::move(lines));
}

}  // namespace magimu
