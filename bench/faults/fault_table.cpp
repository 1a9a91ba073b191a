// SPDX-License-Identifier: BSD-3-Clause
// The table's columns: fault_table.h.
#include "bench/faults/fault_table.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>

namespace magimu {
namespace {

struct Column {
  const char* name;
  std::string (*get)(const SweepRow&);
  void (*set)(SweepRow&, const std::string&);
};

template <auto kMember>
constexpr Column column(const char* name) {
  return {name, [](const SweepRow& row) { return fmt::format("{}", row.*kMember); },
          [](SweepRow& row, const std::string& text) {
            auto& value = row.*kMember;
            using T = std::remove_reference_t<decltype(value)>;
            if constexpr (std::is_same_v<T, std::string>) {
              value = text;
            } else if constexpr (std::is_same_v<T, bool>) {
              value = text == "true";
            } else {
              value = T(std::strtod(text.c_str(), nullptr));
            }
          }};
}

const Column kColumns[] = {column<&SweepRow::index>("index"),
                           column<&SweepRow::kind>("kind"),
                           column<&SweepRow::source>("source"),
                           column<&SweepRow::motion>("motion"),
                           column<&SweepRow::rate_hz>("rate_hz"),
                           column<&SweepRow::duration_s>("duration_s"),
                           column<&SweepRow::magnetometers>("magnetometers"),
                           column<&SweepRow::rich>("rich"),
                           column<&SweepRow::what>("what"),
                           column<&SweepRow::info_code>("info_code"),
                           column<&SweepRow::calibrate_code>("calibrate_code"),
                           column<&SweepRow::diagnose_code>("diagnose_code"),
                           column<&SweepRow::seconds>("seconds"),
                           column<&SweepRow::memory_mb>("memory_mb"),
                           column<&SweepRow::problem>("problem"),
                           column<&SweepRow::clean_trust>("clean_trust"),
                           column<&SweepRow::trust>("trust"),
                           column<&SweepRow::clean_answer>("clean_answer"),
                           column<&SweepRow::answer>("answer"),
                           column<&SweepRow::shift_sigma>("shift_sigma"),
                           column<&SweepRow::truth_squared>("truth_squared"),
                           column<&SweepRow::outside>("outside"),
                           column<&SweepRow::named>("named"),
                           column<&SweepRow::info_permits>("info_permits"),
                           column<&SweepRow::info_can_see>("info_can_see"),
                           column<&SweepRow::unnamed>("unnamed"),
                           column<&SweepRow::contradiction>("contradiction"),
                           column<&SweepRow::findings>("findings"),
                           column<&SweepRow::reason>("reason")};

// One line, and quoted, so that a row is a line.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out + '"';
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool inside = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (inside && i + 1 < line.size() && line[i + 1] == '"') {
        fields.back() += '"';
        ++i;
      } else {
        inside = !inside;
      }
    } else if (c == ',' && !inside) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  if (inside) fields.clear();
  return fields;
}

}  // namespace

std::string table_header() {
  std::string text;
  for (const Column& c : kColumns) text += (text.empty() ? "" : ",") + std::string(c.name);
  return text;
}

std::string table_line(const SweepRow& row) {
  std::string text;
  for (const Column& c : kColumns) text += (text.empty() ? "" : ",") + quoted(c.get(row));
  return text;
}

std::vector<SweepRow> read_table(const std::string& path) {
  std::vector<SweepRow> rows;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = fields_of(line);
    if (fields.size() != std::size(kColumns)) continue;
    SweepRow& row = rows.emplace_back();
    for (std::size_t i = 0; i < fields.size(); ++i) kColumns[i].set(row, fields[i]);
  }
  return rows;
}

}  // namespace magimu
