// SPDX-License-Identifier: BSD-3-Clause
#include "archive/inventory/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string_view>

#include "archive/inventory/file_names.h"
#include "archive/inventory/found_files.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

namespace fs = std::filesystem;

constexpr const char* kColumns[] = {"path", "device", "place", "date", "options"};

// Spreadsheets of countries with a decimal comma write semicolons; the names of the columns have
// neither.
char separator_of(std::string_view text) {
  while (text.starts_with('#') || text.starts_with('\n')) {
    text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  }
  const std::string_view head = text.substr(0, text.find('\n'));
  for (const char c : {';', '\t'}) {
    if (head.find(c) != std::string_view::npos) return c;
  }
  return ',';
}

// Rows of a CSV table (RFC 4180), each with the line on which it begins.
struct TableRow {
  long line = 1;
  std::vector<std::string> fields{""};
};

std::vector<TableRow> rows_of(const std::string& text, const std::string& file) {
  std::vector<TableRow> out{{}};
  long line = 1;
  bool quoted = false;
  std::size_t i = text.starts_with("\xEF\xBB\xBF") ? 3 : 0;
  const char separator = separator_of(std::string_view(text).substr(i));
  for (; i < text.size(); ++i) {
    const char c = text[i];
    std::string& field = out.back().fields.back();
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      field.push_back(text[++i]);
    } else if (c == '"' && (quoted || field.empty())) {
      quoted = !quoted;
    } else if (quoted || (c != separator && c != '\n' && c != '\r')) {
      field.push_back(c);
    } else if (c == separator) {
      out.back().fields.emplace_back();
    } else if (c == '\n') {
      out.push_back({line + 1, {""}});
    }
    if (c == '\n') ++line;
  }
  if (quoted) {
    throw InputError(file, out.back().line, 0, "a quote is opened and never closed",
                     "close it, or double quotes that are meant literally");
  }
  std::erase_if(out, [](const TableRow& r) {
    return r.fields.size() == 1 && (r.fields[0].empty() || r.fields[0].starts_with("#"));
  });
  return out;
}

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

// Which of kColumns each column of the file is.
std::vector<int> columns_of(const TableRow& head, const std::string& file) {
  std::vector<int> out;
  std::set<int> seen;
  for (std::size_t i = 0; i < head.fields.size(); ++i) {
    const std::string name = trimmed(head.fields[i]);
    const auto* found = std::ranges::find(kColumns, name);
    if (found == std::end(kColumns)) {
      throw InputError(file, head.line, long(i) + 1,
                       fmt::format("there is no column {} in a manifest", quoted_text(name)),
                       "the first line names the columns: path,device,place,date,options");
    }
    out.push_back(int(found - kColumns));
    if (!seen.insert(out.back()).second) {
      throw InputError(file, head.line, long(i) + 1, "column " + name + " occurs twice",
                       "leave one of them out");
    }
  }
  if (!seen.contains(0)) {
    throw InputError(file, head.line, 0, "a manifest needs a column path",
                     "the first line names the columns: path,device,place,date,options");
  }
  return out;
}

// What nobody has said: devices, and dates where names have them.
void guess_what_is_missing(std::vector<ManifestEntry>& entries, const std::string& path) {
  for (ManifestEntry& e : entries) {
    e.device_guessed = e.device.empty();
    if (e.date.empty()) e.date = date_in_path(e.shown);
  }
  const std::vector<DeviceReading> readings = device_readings_of(entries, path);
  for (std::size_t i = 0; i < entries.size() && !readings.empty(); ++i) {
    if (entries[i].device_guessed) entries[i].device = readings.front().device[i];
  }
}

}  // namespace

std::vector<ManifestEntry> read_manifest(const std::string& path) {
  const std::vector<TableRow> rows = rows_of(read_file(path), path);
  if (rows.empty()) {
    throw InputError(path, 0, 0, "the manifest is empty",
                     "its first line names the columns: path,device,place,date,options");
  }
  const std::vector<int> columns = columns_of(rows.front(), path);
  const fs::path folder = fs::path(path).parent_path();
  std::vector<ManifestEntry> out;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    ManifestEntry e;
    if (rows[r].fields.size() != columns.size()) {
      e.unreadable_row = true;
      e.problem = fmt::format("line {} of the manifest has {} fields, its first line {}",
                              rows[r].line, rows[r].fields.size(), columns.size());
    }
    for (std::size_t i = 0; i < std::min(columns.size(), rows[r].fields.size()); ++i) {
      std::string* const to[] = {&e.shown, &e.device, &e.place, &e.date, &e.options};
      *to[columns[i]] = trimmed(rows[r].fields[i]);
    }
    if (e.shown.empty() && !e.unreadable_row) {
      e.unreadable_row = true;
      e.problem = fmt::format("line {} of the manifest names no path", rows[r].line);
    }
    if (!e.date.empty() && !days_of(e.date) && !e.unreadable_row) {
      e.unreadable_row = true;
      e.problem = fmt::format(
          "line {} of the manifest: {} is no date (write 2024-05-03 or "
          "2024-05-03T14:07:30)",
          rows[r].line, quoted_text(e.date));
    }
    e.path = (folder / e.shown).string();
    out.push_back(std::move(e));
  }
  guess_what_is_missing(out, path);
  return out;
}

std::vector<ManifestEntry> manifest_of_folder(const std::string& path) {
  std::vector<ManifestEntry> out;
  for (const std::string& file : files_below(path)) {
    ManifestEntry& e = out.emplace_back();
    e.path = file;
    e.shown = fs::path(file).lexically_relative(path).string();
  }
  std::ranges::sort(out, {}, &ManifestEntry::shown);
  guess_what_is_missing(out, path);
  return out;
}

std::vector<ManifestEntry> manifest_of(const std::string& path) {
  std::error_code error;
  return fs::is_directory(path, error) ? manifest_of_folder(path) : read_manifest(path);
}

std::vector<DeviceReading> device_readings_of(const std::vector<ManifestEntry>& entries,
                                              const std::string& path) {
  std::error_code error;
  const fs::path folder = fs::is_directory(path, error) ? fs::path(path) : fs::path(path) / "..";
  const fs::path full = fs::weakly_canonical(folder, error) / "";
  const std::string whole = full.parent_path().filename().string();
  std::vector<std::string> shown;
  for (const ManifestEntry& e : entries) shown.push_back(e.shown);
  return device_readings(shown, whole.empty() ? "device" : whole);
}

std::optional<std::vector<std::string>> split_words(const std::string& text) {
  std::vector<std::string> out;
  char quote = 0;
  bool within = false;
  for (const char c : text) {
    if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '"' || c == '\'')) {
      quote = c;
      if (!within) out.emplace_back();
      within = true;
    } else if (quote == 0 && (c == ' ' || c == '\t')) {
      within = false;
    } else {
      if (!within) out.emplace_back();
      within = true;
      out.back().push_back(c);
    }
  }
  if (quote != 0) return std::nullopt;
  return out;
}

std::optional<double> days_of(const std::string& date) {
  int y = 0, m = 0, d = 0, hours = 0, minutes = 0, used = 0;
  double seconds = 0.0;
  if (std::sscanf(date.c_str(), "%4d-%2d-%2d%n", &y, &m, &d, &used) != 3) return std::nullopt;
  const char* rest = date.c_str() + used;
  if (*rest == 'T' || *rest == ' ') {
    if (std::sscanf(rest + 1, "%2d:%2d%n", &hours, &minutes, &used) != 2) return std::nullopt;
    rest += 1 + used;
    if (*rest == ':') {
      if (std::sscanf(rest + 1, "%lf%n", &seconds, &used) != 1) return std::nullopt;
      rest += 1 + used;
    }
    if (*rest == 'Z') ++rest;
  }
  using namespace std::chrono;
  const year_month_day day{year(y), month(unsigned(m)), std::chrono::day(unsigned(d))};
  if (*rest != '\0' || !day.ok() || hours > 23 || minutes > 59 || seconds >= 61.0) {
    return std::nullopt;
  }
  return double(sys_days(day).time_since_epoch().count()) + (hours * 60.0 + minutes) / 1440.0 +
         seconds / 86400.0;
}

}  // namespace magimu
