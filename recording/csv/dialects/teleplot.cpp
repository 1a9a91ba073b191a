// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/teleplot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/csv/dialects/axis_gatherer.h"

namespace magimu {
namespace {

constexpr std::string_view kUnitMark = "\xC2\xA7";  // a paragraph sign

struct TeleplotLine {
  std::string_view name, time, value, unit;
};

// A line with one point. Nothing for lines of text, several points or shapes.
std::optional<TeleplotLine> teleplot_line(std::string_view line) {
  line = csv_trimmed(line);
  if (!line.starts_with('>')) return std::nullopt;
  line.remove_prefix(1);
  line = line.substr(0, line.find('|'));
  TeleplotLine out;
  if (const std::size_t unit = line.find(kUnitMark); unit != std::string_view::npos) {
    out.unit = csv_trimmed(line.substr(unit + kUnitMark.size()));
    line = line.substr(0, unit);
  }
  const std::size_t last = line.rfind(':');
  if (last == std::string_view::npos || last == 0) return std::nullopt;
  out.value = csv_trimmed(line.substr(last + 1));
  std::string_view front = line.substr(0, last);
  if (const std::size_t first = front.find(':'); first != std::string_view::npos) {
    out.time = csv_trimmed(front.substr(first + 1));
    front = front.substr(0, first);
  }
  out.name = csv_trimmed(front);
  const bool whole = !out.name.empty() && field_kind(out.value) == FieldKind::kNumber &&
                     (out.time.empty() || field_kind(out.time) == FieldKind::kNumber);
  return whole ? std::optional(out) : std::nullopt;
}

class TeleplotRows final : public LineTranslator {
 public:
  TeleplotRows(std::map<std::string, std::size_t, std::less<>> column_of, AxisGatherer gatherer,
               bool with_time)
      : column_of_(std::move(column_of)), gatherer_(std::move(gatherer)), with_time_(with_time) {}

  std::optional<std::string_view> row(std::string_view line) override {
    const std::optional<TeleplotLine> it = teleplot_line(line);
    if (!it || it->time.empty() == with_time_) return std::nullopt;
    const auto column = column_of_.find(it->name);
    if (column == column_of_.end()) return std::nullopt;
    return gatherer_.add(column->second, it->time, it->value);
  }

 private:
  std::map<std::string, std::size_t, std::less<>> column_of_;
  AxisGatherer gatherer_;
  bool with_time_;
};

}  // namespace

std::optional<CsvDialect> teleplot_dialect(const std::vector<HeadLine>& lines,
                                           const CsvOptions& options) {
  constexpr std::size_t kMostNames = 4096;
  std::vector<std::pair<std::string, std::string>> names;  // with their units
  std::size_t points = 0, looked_at = 0, timed = 0;
  for (const HeadLine& line : lines) {
    if (is_comment(line.text)) continue;
    ++looked_at;
    const std::optional<TeleplotLine> it = teleplot_line(line.text);
    if (!it) continue;
    ++points;
    timed += it->time.empty() ? 0 : 1;
    const bool known =
        std::ranges::any_of(names, [&](const auto& name) { return name.first == it->name; });
    if (!known && names.size() < kMostNames) names.emplace_back(it->name, it->unit);
  }
  if (points < 3 || 2 * points < looked_at) return std::nullopt;
  const bool with_time = 2 * timed > points;
  CsvDialect out;
  if (with_time) out.names.emplace_back("time (ms)");
  std::map<std::string, std::size_t, std::less<>> column_of;
  std::vector<std::string> ours;
  for (std::size_t c = 0; c < names.size(); ++c) {
    const auto& [name, unit] = names[c];
    column_of.emplace(name, c);
    out.names.push_back(unit.empty() ? name : fmt::format("{} ({})", name, unit));
    const auto given = options.columns.find(out.names.back());
    const std::string its =
        given == options.columns.end() ? csv_name(out.names.back()).name : given->second;
    ours.push_back(its.empty() ? name : its);
  }
  out.first_row = lines.front().number;
  out.one_sensor_a_line = !with_time;
  out.notes.emplace_back(with_time ? "lines of Teleplot, with times in ms"
                                   : "lines of Teleplot, without times");
  out.translator = std::make_shared<TeleplotRows>(std::move(column_of),
                                                  AxisGatherer(ours, with_time), with_time);
  return out;
}

}  // namespace magimu
