// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/labelled_dialect.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/text_fields.h"

namespace magimu {
namespace {

// The fields in the order in which they appear.
struct Labels {
  std::vector<LabelledField> fields;
  std::vector<std::string> units;
  std::map<std::string, std::size_t> components;  // of a label

  void add(const LabelledNumber& number) {
    constexpr std::size_t kMost = 4096;
    std::size_t& count = components[number.label];
    count = std::max(count, number.component + 1);
    const auto same = [&](const LabelledField& f) {
      return f.label == number.label && f.component == number.component;
    };
    const auto found = std::ranges::find_if(fields, same);
    if (found == fields.end() && fields.size() < kMost) {
      fields.push_back({number.label, number.component});
      units.push_back(number.unit);
    }
  }

  std::string bare_name(std::size_t i) const {
    std::string name = fields[i].label;
    const std::size_t count = components.at(name);
    if (count == 3) name += std::string("_") + "xyz"[fields[i].component];
    if (count != 3 && count > 1) name += fmt::format("[{}]", fields[i].component);
    return name;
  }

  // A unit usually stands behind the last axis only, and is that of all axes.
  std::string name(std::size_t i) const {
    const auto sensor = [this](std::size_t k) {
      const std::string its = csv_name(bare_name(k)).name;
      return its.substr(0, its.find('_'));
    };
    for (std::size_t k = 0; k < fields.size(); ++k) {
      if (units[k].empty() || (k != i && (sensor(i).empty() || sensor(k) != sensor(i)))) continue;
      return bare_name(i) + " (" + units[k] + ")";
    }
    return bare_name(i);
  }
};

bool is_number_start(char c) { return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.'; }

// The nine numbers of MotionCal's lines.
std::vector<std::string> motioncal_names(bool raw) {
  std::vector<std::string> names;
  for (const auto& [sensor, unit] : {std::pair("acc", raw ? 9.80665 / 8192 : 1.0),
                                     {"gyr", raw ? 0.017453292519943295 / 16 : 1.0},
                                     {"mag", raw ? 0.1 : 1.0}}) {
    for (const char axis : {'x', 'y', 'z'}) {
      names.push_back(fmt::format("{}_{} ({})", sensor, axis, unit));
    }
  }
  return names;
}

}  // namespace

std::optional<CsvDialect> labelled_dialect(const std::vector<HeadLine>& lines,
                                           const CsvOptions& options) {
  constexpr std::size_t kSample = 200;
  Labels labels;
  // Razor's lines begin with '#': "#A-C=1.0,2.0,3.0".
  const bool marked =
      std::ranges::all_of(lines, [](const HeadLine& line) { return is_comment(line.text); });
  std::size_t labelled = 0, looked_at = 0, clocks = 0, begun_by_label = 0, most = 0;
  for (std::size_t i = lines.size() > kSample ? lines.size() - kSample : 0; i < lines.size(); ++i) {
    if (is_comment(lines[i].text) != marked) continue;
    ++looked_at;
    std::string_view line = lines[i].text;
    clocks += leading_clock(line) ? 1 : 0;
    const std::vector<LabelledNumber> numbers = labelled_numbers(line);
    // A row of a table may hold a word or two; a labelled line has about as many labels as numbers.
    const bool marks = line.find_first_of(":=[") != std::string_view::npos;
    if (numbers.size() < 2 || !marks || field_kind(line) != FieldKind::kWord) continue;
    ++labelled;
    most = std::max(most, numbers.size());
    begun_by_label += is_number_start(line.front()) ? 0 : 1;
    for (const LabelledNumber& number : numbers) labels.add(number);
  }
  if (labelled == 0 || 2 * labelled < looked_at) return std::nullopt;
  const auto nine = [&](const char* label) {
    const auto found = labels.components.find(label);
    return found != labels.components.end() && found->second == 9;
  };
  const char* const motioncal = nine("Uni") ? "Uni" : nine("Raw") ? "Raw" : nullptr;
  CsvDialect out;
  std::vector<LabelledField> fields;
  const bool clock = 2 * clocks > looked_at;
  if (clock) out.names.emplace_back("time");
  if (motioncal != nullptr) {
    for (std::size_t i = 0; i < 9; ++i) fields.push_back({motioncal, i});
    const std::vector<std::string> names = motioncal_names(std::string_view(motioncal) == "Raw");
    out.names.insert(out.names.end(), names.begin(), names.end());
    out.notes.push_back(fmt::format("lines of MotionCal, {}:", motioncal));
  } else {
    std::size_t known = 0;
    for (std::size_t i = 0; i < labels.fields.size(); ++i) {
      out.names.push_back(labels.name(i));
      known += csv_name(labels.name(i)).name.empty() ? 0 : 1;
    }
    const bool by_option = !options.columns.empty() || !options.header.empty();
    if (known < 3 && !(by_option && begun_by_label == labelled)) return std::nullopt;
    fields = labels.fields;
    out.one_sensor_a_line = most < fields.size();
    out.notes.emplace_back("every line holds labelled numbers");
  }
  if (!options.header.empty()) {
    std::vector<std::string> given = text_fields(options.header, ',');
    if (given.size() == out.names.size()) out.names = std::move(given);
  }
  out.marked_rows = marked;
  out.first_row = lines.empty() ? 1 : lines.front().number;
  out.translator = labelled_translator(std::move(fields), clock);
  return out;
}

}  // namespace magimu
