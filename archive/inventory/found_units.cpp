// SPDX-License-Identifier: BSD-3-Clause
#include "archive/inventory/found_units.h"

#include <algorithm>

#include "recording/checks/quality.h"
#include "recording/data/units.h"

namespace magimu {
namespace {

// "give the file's unit: --unit gyr=deg/s" -> "gyr", "deg/s"; nothing where the unit is a guess, or
// one of several: only who knows the device can say.
struct NamedUnit {
  std::string quantity, unit;
};

NamedUnit unit_in(const std::string& remedy) {
  const std::string option = "--unit ";
  const std::size_t at = remedy.find(option);
  if (at == std::string::npos) return {};
  const std::string word =
      remedy.substr(at + option.size(), remedy.find(' ', at + option.size()) - at - option.size());
  const std::size_t equals = word.find('=');
  const std::string_view rest = std::string_view(remedy).substr(at + option.size() + word.size());
  if (equals == std::string::npos || rest.starts_with(" (a guess") ||
      rest.find(option) != std::string_view::npos) {
    return {};
  }
  return {word.substr(0, equals), word.substr(equals + 1)};
}

void scale_series(VectorSeries& series, double factor) {
  for (Vector3& v : series.v) v *= factor;
}

void rescale(Recording& recording, const std::string& quantity, double factor) {
  if (quantity == "acc") scale_series(recording.acc, factor);
  if (quantity == "gyr") scale_series(recording.gyr, factor);
  if (quantity != "mag") return;
  for (VectorSeries& mag : recording.mag) scale_series(mag, factor);
}

}  // namespace

std::vector<std::string> put_units_right(Recording& recording) {
  std::vector<std::string> out, done;
  // One quantity at a time: with the gyroscope in its unit the magnetometer can be judged.
  for (int round = 0; round < 3; ++round) {
    NamedUnit found;
    for (const Issue& issue : check_units(recording)) {
      if (issue.severity != Severity::kFatal) continue;
      const NamedUnit unit = unit_in(issue.remedy);
      if (std::ranges::find(done, unit.quantity) != done.end()) continue;
      if (unit.quantity == "acc" || unit.quantity == "gyr" || unit.quantity == "mag") {
        found = unit;
        break;
      }
    }
    if (found.quantity.empty()) return out;
    const std::optional<double> ours = unit_in_ours(found.quantity, found.unit);
    if (!ours) return out;
    const auto given = recording.file_units.find(found.quantity);
    const double before = given == recording.file_units.end() ? 1.0 : given->second;
    rescale(recording, found.quantity, *ours / before);
    recording.file_units[found.quantity] = *ours;
    done.push_back(found.quantity);
    out.push_back("--unit " + found.quantity + "=" + found.unit);
    recording.cautions.push_back("the samples tell the unit of " + found.quantity + ": " +
                                 found.unit);
  }
  return out;
}

}  // namespace magimu
