// SPDX-License-Identifier: BSD-3-Clause
// A logger's rows and their text: fault_log.h.
#include "bench/faults/fault_log.h"

#include <fmt/format.h>

#include <algorithm>

namespace magimu {
namespace {

constexpr double kOneRow = 1e-9;  // s

std::string number(double value, int digits) {
  return digits == kAllDigits ? fmt::format("{}", value) : fmt::format("{:.{}f}", value, digits);
}

}  // namespace

std::vector<std::size_t> Log::rows_of(int sensor) const {
  std::vector<std::size_t> list;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r].has_sensor(sensor) && rows[r].line.empty()) list.push_back(r);
  }
  return list;
}

Log log_of(const Recording& recording) {
  Log log;
  log.names = {"acc", "gyr"};
  std::vector<const VectorSeries*> series = {&recording.acc, &recording.gyr};
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    log.names.push_back(recording.mag_names[m]);
    series.push_back(&recording.mag[m]);
  }
  log.digits.assign(log.names.size(), kAllDigits);
  struct At {
    double t;
    int sensor;
    std::size_t k;
  };
  std::vector<At> all;
  for (int s = 0; s < log.sensors(); ++s) {
    const VectorSeries& one = *series[std::size_t(s)];
    for (std::size_t k = 0; k < one.size(); ++k) all.push_back({one.t[k], s, k});
  }
  std::stable_sort(all.begin(), all.end(), [](const At& a, const At& b) { return a.t < b.t; });
  for (const At& at : all) {
    if (log.rows.empty() || at.t > log.rows.back().t + kOneRow) {
      log.rows.emplace_back();
      log.rows.back().t = at.t;
      log.rows.back().v.assign(log.names.size(), Vector3::Zero());
    }
    log.rows.back().v[std::size_t(at.sensor)] = series[std::size_t(at.sensor)]->v[at.k];
    log.rows.back().has |= 1u << at.sensor;
  }
  return log;
}

std::string field_text(const Log& log, int sensor, double value) {
  return number(value, log.digits[std::size_t(sensor)]);
}

std::string row_text(const Log& log, const LogRow& row) {
  if (!row.line.empty()) return row.line;
  std::string text = row.time_token.empty() ? number(row.t, log.time_digits) : row.time_token;
  for (int s = 0; s < log.sensors(); ++s) {
    for (int axis = 0; axis < 3; ++axis) {
      text += ',';
      const auto token = row.tokens.find(3 * s + axis);
      if (token != row.tokens.end()) {
        text += token->second;
      } else if (row.has_sensor(s)) {
        text += field_text(log, s, row.v[std::size_t(s)][axis]);
      }
    }
  }
  return text;
}

std::string header_text(const Log& log) {
  std::string text = log.time_name;
  for (const std::string& name : log.names) {
    for (const char axis : {'x', 'y', 'z'}) text += fmt::format(",{}_{}", name, axis);
  }
  return text;
}

std::string file_text(const Log& log) {
  std::string text = header_text(log) + '\n';
  for (const LogRow& row : log.rows) text += row_text(log, row) + '\n';
  return text;
}

}  // namespace magimu
