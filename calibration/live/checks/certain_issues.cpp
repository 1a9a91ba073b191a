// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/checks/certain_issues.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>
#include <vector>

#include "recording/data/units.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

// s of data from which a check of whole recordings holds for the beginning of one: checks of rates
// need some hundred intervals; a check of where sensors begin and end allows a tenth of the whole.
constexpr double kForRates = 4.0, kForSpans = 15.0, kForUnits = 15.0;
// rad, sum of all turns: from there on the range of the magnetometer's readings shows a unit
// without a name.
constexpr double kTurnedEnoughToTell = M_PI;
// Ratio of the unit that would fit to the unit in use, below which the latter must be wrong. A hand
// that shakes a board does not reach 16 g; the few turns at the beginning are known to a factor of
// two either way.
constexpr double kNoAcceleration = 1.0 / 16.0, kNoRate = 0.25;
constexpr double kTurnedRate = 0.2;  // rad/s, mean: the sensor is being turned
constexpr double kChangedShare =
    0.3;  // change of a reading, as a share of the usual length, that shows a turn

bool changes(const VectorSeries& s) {
  if (s.empty()) return false;
  Vector3 low = s.v.front(), high = low;
  double usual = 0.0;
  for (const Vector3& v : s.v) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
    usual += v.norm() / double(s.size());
  }
  return (high - low).norm() > kChangedShare * usual;
}

bool is_turned(const Recording& r) {
  double rate = 0.0;
  for (const Vector3& v : r.gyr.v) rate += v.norm() / double(r.gyr.size());
  return rate > kTurnedRate || changes(r.acc) || std::ranges::any_of(r.mag, changes);
}

double turns_of(const VectorSeries& gyr) {
  double sum = 0.0;
  for (std::size_t k = 1; k < gyr.size(); ++k) sum += gyr.v[k].norm() * (gyr.t[k] - gyr.t[k - 1]);
  return sum;
}

double usual_length(const VectorSeries& s) {
  std::vector<double> lengths;
  for (const Vector3& v : s.v) lengths.push_back(v.norm());
  return median(std::move(lengths));
}

// The unit that a remedy gives over the unit in use; 0 if it gives none.
double unit_ratio(const Issue& issue, const Recording& piece) {
  const std::string quantity = issue.sensor.substr(0, 3), option = "--unit " + quantity + "=";
  const std::size_t at = issue.remedy.find(option);
  if (at == std::string::npos) return 0.0;
  const std::string rest = issue.remedy.substr(at + option.size());
  const auto given = piece.file_units.find(quantity);
  return unit_in_ours(quantity, rest.substr(0, rest.find(' '))).value_or(0.0) /
         (given == piece.file_units.end() ? 1.0 : given->second);
}

// Whether an issue about units, found in a few seconds, is certain.
bool certain_unit(const Issue& issue, const Recording& piece, double length_s) {
  if (length_s >= kForUnits) return true;
  const bool named = !named_option(issue).empty();
  if (issue.sensor.starts_with("mag")) return named || turns_of(piece.gyr) > kTurnedEnoughToTell;
  const double ratio = unit_ratio(issue, piece);
  if (issue.sensor == "acc") return named || ratio < kNoAcceleration;
  // Noise and accelerations turn directions as well, so a gyroscope may seem to read too little.
  return named || ratio < kNoRate;
}

}  // namespace

bool is_any_of(const std::string& kind, std::initializer_list<const char*> kinds) {
  return std::ranges::any_of(kinds, [&](const char* k) { return kind == k; });
}

std::string named_option(const Issue& issue) {
  if (!is_any_of(issue.kind, {"axes", "unit"})) return "";
  const std::size_t at = issue.remedy.find('=');
  if (at == std::string::npos || at + 1 >= issue.remedy.size()) return "";
  const char first = issue.remedy[at + 1];
  const bool name = std::isalpha(static_cast<unsigned char>(first)) != 0 || first == '-';
  return name ? issue.remedy : "";
}

bool certain(const Issue& issue, const Recording& piece, double length_s) {
  if (issue.severity == Severity::kNote) {
    const bool clipped =
        issue.kind == "set_aside" && issue.problem.find("clipped") != std::string::npos;
    if (issue.kind != "repeats") return clipped;
  }
  // At rest a coarse converter repeats its readings.
  if (issue.kind == "repeats" && !is_turned(piece)) return false;
  if (issue.kind == "constant" || issue.kind == "copied") return is_turned(piece);
  if (issue.kind == "unit") return certain_unit(issue, piece, length_s);
  // A hand that swings the board may halve the usual reading, but not for long.
  if (issue.kind == "gravity") return length_s >= kForUnits || usual_length(piece.acc) < 2.0;
  // This check needs attitudes to all sides, which a minute hardly has.
  if (issue.kind == "acc_scale") return false;
  if (issue.kind == "span") return length_s >= kForSpans;
  if (is_any_of(issue.kind, {"jitter", "interpolation", "repeats", "field_size"})) {
    return length_s >= kForRates;
  }
  return true;
}

}  // namespace magimu
