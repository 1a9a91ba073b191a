// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "apps/study_page.h"
#include "recording/data/error.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStudyFile = "study.json";  // by it a folder is known as a study's

// RFC 4180.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string csv_field(const StudyCell& cell) {
  if (const std::string* text = std::get_if<std::string>(&cell)) return csv_field(*text);
  const double value = std::get<double>(cell);
  return std::isfinite(value) ? fmt::format("{}", value) : "";
}

std::string csv(const StudyTable& table) {
  std::string out;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    out += (i > 0 ? "," : "") + csv_field(table.columns[i]);
  }
  out += "\n";
  for (const std::vector<StudyCell>& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) out += (i > 0 ? "," : "") + csv_field(row[i]);
    out += "\n";
  }
  return out;
}

// JSON knows no numbers that are none, and no infinity: null.
nlohmann::ordered_json number(double x) {
  return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json();
}

nlohmann::ordered_json json_of(const StudyTable& table) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const std::vector<StudyCell>& row : table.rows) {
    nlohmann::ordered_json cells = nlohmann::ordered_json::array();
    for (const StudyCell& cell : row) {
      const std::string* text = std::get_if<std::string>(&cell);
      cells.push_back(text ? nlohmann::ordered_json(*text) : number(std::get<double>(cell)));
    }
    rows.push_back(cells);
  }
  return {{"name", table.name}, {"title", table.title}, {"columns", table.columns}, {"rows", rows}};
}

nlohmann::ordered_json json_of(const StudyCheck& check) {
  nlohmann::ordered_json json = {{"what", check.what},
                                 {"value", number(check.value)},
                                 {"low", number(check.low)},
                                 {"high", number(check.high)},
                                 {"kind", check.by_chance ? "band_99" : "limit"},
                                 {"inside", check.inside()}};
  if (check.by_chance) json["inside_99_99"] = check.inside_wide();
  return json;
}

nlohmann::ordered_json json_of(const Study& study) {
  nlohmann::ordered_json json = {
      {"name", study.name}, {"title", study.title}, {"question", study.question}};
  json["findings"] = study.findings;
  json["tables"] = json["checks"] = nlohmann::ordered_json::array();
  for (const StudyTable& table : study.tables) json["tables"].push_back(json_of(table));
  for (const StudyCheck& check : study.checks) json["checks"].push_back(json_of(check));
  json["seconds"] = study.seconds;
  return json;
}

[[noreturn]] void refuse_folder(const std::string& folder, const std::string& problem,
                                const std::string& remedy) {
  throw InputError(folder, 0, 0, problem, remedy);
}

}  // namespace

std::map<std::string, std::string> study_files(const std::vector<Study>& studies,
                                               const StudyOptions& options) {
  std::map<std::string, std::string> files;
  nlohmann::ordered_json json = {{"format", "magimu-study/1"},
                                 {"runs", options.runs},
                                 {"short", options.brief},
                                 {"verdict", judge(studies).sentence}};
  json["studies"] = nlohmann::ordered_json::array();
  for (const Study& study : studies) {
    json["studies"].push_back(json_of(study));
    for (const StudyTable& table : study.tables) {
      files[study.name + "_" + table.name + ".csv"] = csv(table);
    }
    for (const StudyFigure& figure : study.figures) {
      files[study.name + "_" + figure.name + ".svg"] = study_svg(figure);
    }
  }
  files[kStudyFile] = json.dump(2) + "\n";
  files["study.html"] = study_page(studies, options);
  return files;
}

void check_study_folder(const std::string& folder) {
  std::error_code error;
  const fs::path path(folder);
  const fs::path parent = fs::absolute(path).parent_path();
  if (!fs::is_directory(parent, error)) {
    refuse_folder(folder, "its folder does not exist", "make the folder first");
  }
  if (::access(parent.c_str(), W_OK) != 0) {
    refuse_folder(folder, "nothing can be written there", "name another folder");
  }
  if (!fs::exists(path, error)) return;
  if (!fs::is_directory(path, error)) {
    refuse_folder(folder, "it is a file", "name a folder for the tables and figures");
  }
  if (fs::is_empty(path, error) || fs::exists(path / kStudyFile, error)) return;
  refuse_folder(folder, "it holds something else than an earlier study",
                "name a folder that does not exist yet");
}

void write_study_folder(const std::string& folder,
                        const std::map<std::string, std::string>& files) {
  check_study_folder(folder);
  fs::path path = fs::absolute(folder);
  if (path.filename().empty()) path = path.parent_path();  // FOLDER/
  const std::string own = fmt::format("{}.{}", path.string(), ::getpid());
  const fs::path made = own + ".new", old = own + ".old";
  try {
    fs::create_directory(made);
    for (const auto& [name, text] : files) write_atomically((made / name).string(), text);
    const bool replaced = fs::exists(path);
    if (replaced) fs::rename(path, old);
    std::error_code error;
    fs::rename(made, path, error);
    if (error) {
      if (replaced) fs::rename(old, path);
      throw fs::filesystem_error("rename", made, path, error);
    }
    fs::remove_all(old, error);
  } catch (const std::exception& e) {
    std::error_code ignored;
    fs::remove_all(made, ignored);
    if (dynamic_cast<const InputError*>(&e) != nullptr) throw;
    refuse_folder(folder, std::string("the study cannot be written: ") + e.what(),
                  "look at the disk and at who may write there");
  }
}

}  // namespace magimu::apps
