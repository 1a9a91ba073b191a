// SPDX-License-Identifier: BSD-3-Clause
// Is the fault named? Sentences of a result, and words in them: fault_verdict.h.
#include <algorithm>
#include <array>
#include <cctype>
#include <regex>
#include <set>
#include <sstream>

#include "bench/faults/fault_verdict.h"

namespace magimu {
namespace {

using nlohmann::json;

// What stands in every file: candidates that were tested, statistics by their names, how it went.
const std::set<std::string> kSilent = {
    "scan",       "confusable_with", "provenance",  "trace",    "covariance", "covariance_model",
    "noise",      "evidence",        "disturbance", "prior",    "format",     "departures_after",
    "recordings", "recording",       "departures",  "expected", "unit",       "parameters",
    "columns",    "termination"};

std::string lowered(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

// The strings of one object belong together: {"kind": "stuck", "sensor": "mag"}.
void collect(const json& value, std::vector<std::string>& lines) {
  if (value.is_string()) lines.push_back(lowered(value.get<std::string>()));
  if (value.is_array()) {
    for (const json& item : value) collect(item, lines);
  }
  if (!value.is_object()) return;
  std::string together;
  for (const auto& [key, item] : value.items()) {
    if (kSilent.contains(key)) continue;
    if (item.is_string()) {
      together += lowered(item.get<std::string>()) + ' ';
    } else {
      collect(item, lines);
    }
  }
  // A check that is passed says nothing.
  const auto status = value.find("status");
  const bool passed = status != value.end() && *status == "ok";
  if (!together.empty() && !passed) lines.push_back(together);
}

void collect(const std::string& text, std::vector<std::string>& lines) {
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(lowered(line));
}

// Numbers differ from one recording to the next; a sentence does not.
std::string without_numbers(const std::string& line) {
  std::string out;
  for (const char c : line) {
    if (std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '+')
      continue;
    if (c == ' ' && (out.empty() || out.back() == ' ')) continue;
    out += c;
  }
  return out;
}

bool matches(const std::string& line, const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return std::regex_search(line, std::regex(word));
  });
}

const std::vector<std::string>& names_of_sensor(int sensor) {
  static const std::array<std::vector<std::string>, 3> names = {
      std::vector<std::string>{"\\bacc", "accelerometer", "gravity", "specific force", "imu\\b"},
      {"\\bgyr", "gyroscope", "rate of turn", "imu\\b"},
      {"\\bmag", "compass", "field", "iron"}};
  return names[std::size_t(std::clamp(sensor, 0, 2))];
}

bool says(const std::vector<std::string>& lines, const std::vector<std::string>& usual,
          const FaultKind& kind, int sensor) {
  std::set<std::string> known;
  for (const std::string& line : usual) known.insert(without_numbers(line));
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
    if (known.contains(without_numbers(line)) || !matches(line, kind.words)) return false;
    return !kind.of_sensor || sensor < 0 || matches(line, names_of_sensor(sensor));
  });
}

}  // namespace

Sentences sentences(const Verdicts& v) {
  Sentences said;
  collect(v.survey, said.info);
  collect(v.info.err, said.info);
  if (v.survey.is_null()) collect(v.info.out, said.info);
  collect(v.calibration, said.calibrate);
  collect(v.calibrate.err, said.calibrate);
  collect(v.diagnosis, said.diagnose);
  collect(v.diagnose.err, said.diagnose);
  return said;
}

Named named(const FaultKind& kind, const Damage& damage, const Sentences& said,
            const Sentences& undamaged) {
  Named out;
  out.by_info = says(said.info, undamaged.info, kind, damage.sensor);
  out.by_calibrate = says(said.calibrate, undamaged.calibrate, kind, damage.sensor);
  out.by_diagnose = says(said.diagnose, undamaged.diagnose, kind, damage.sensor);
  return out;
}

}  // namespace magimu
