// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/use/applied_json.h"

#include <array>
#include <cmath>

#include "graph/json_numbers.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostNumber = 16;  // of sensors of a kind on one vehicle

AppliedCorrections applied_corrections(const Recording& r) {
  AppliedCorrections out;
  std::vector<std::string> sensors = r.mag_names;
  sensors.insert(sensors.end(), {"acc", "gyr"});
  for (const std::string& sensor : sensors) {
    if (auto applied = applied_to(r.file_units, sensor)) out[sensor] = *applied;
  }
  return out;
}

bool same(const AppliedCorrections& a, const AppliedCorrections& b) {
  return applied_json(a) == applied_json(b);
}

Matrix3 matrix_from(const Json& rows) {
  const auto numbers = rows.get<std::array<std::array<double, 3>, 3>>();
  Matrix3 out;
  for (int i = 0; i < 9; ++i) out(i / 3, i % 3) = numbers[std::size_t(i / 3)][std::size_t(i % 3)];
  return out;
}

}  // namespace

AppliedCorrections applied_to_all(const std::vector<const Recording*>& recordings) {
  if (recordings.empty()) return {};
  AppliedCorrections first = applied_corrections(*recordings.front());
  for (const Recording* each : recordings) {
    if (!same(applied_corrections(*each), first)) return {};
  }
  return first;
}

void add_applied(Json& file, const std::vector<const Recording*>& recordings) {
  const AppliedCorrections applied = applied_to_all(recordings);
  if (!applied.empty()) file["applied"] = applied_json(applied);
}

Json applied_json(const AppliedCorrections& applied) {
  Json out = Json::object();
  for (const auto& [sensor, is] : applied) {
    out[sensor] = {{"by", is.by == Autopilot::kPx4 ? "px4" : "ardupilot"},
                   {"number", is.number},
                   {"offset", json_numbers<Json>(is.offset)},
                   {"matrix", json_numbers<Json>(is.matrix)},
                   {"rotation", json_numbers<Json>(is.rotation)}};
  }
  return out;
}

AppliedCorrections applied_from_json(const Json& file, const std::string& name) {
  AppliedCorrections out;
  if (!file.is_object() || !file.contains("applied")) return out;
  try {
    for (const auto& [sensor, is] : file.at("applied").items()) {
      AppliedCorrection& applied = out[sensor];
      const auto offset = is.at("offset").get<std::array<double, 3>>();
      applied.by =
          is.at("by").get<std::string>() == "px4" ? Autopilot::kPx4 : Autopilot::kArdupilot;
      applied.number = is.at("number").get<int>();
      applied.offset = Vector3(offset[0], offset[1], offset[2]);
      applied.matrix = matrix_from(is.at("matrix"));
      applied.rotation = matrix_from(is.at("rotation"));
      const bool usable = applied.matrix.allFinite() && applied.rotation.allFinite() &&
                          applied.offset.allFinite() && applied.matrix.determinant() > 0.0 &&
                          applied.number >= 0 && applied.number < kMostNumber;
      if (!usable) throw InputError(name, 0, 0, "its field \"applied\" cannot be", "make it anew");
    }
  } catch (const nlohmann::json::exception&) {
    throw InputError(name, 0, 0, "its field \"applied\" is not what magimu writes",
                     "make it anew with magimu calibrate");
  }
  return out;
}

}  // namespace magimu
