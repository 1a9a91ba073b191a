// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/survey/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "factors/sensor_model.h"

namespace magimu {
namespace {

constexpr int kDirections = 200;
constexpr double kNear = 20.0 * kDegree;
constexpr double kSeen = 50.0 * kDegree;         // an axis that came no nearer to "up" is missing
constexpr double kEnoughTurn = 360.0 * kDegree;  // about each axis, to and fro
constexpr const char* kAxes[6] = {"x", "-x", "y", "-y", "z", "-z"};

Vector3 axis(int i) { return Vector3::Unit(i / 2) * (i % 2 == 0 ? 1.0 : -1.0); }

// Evenly on the sphere, along a spiral.
std::vector<Vector3> even_directions() {
  std::vector<Vector3> out;
  const double golden = M_PI * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections, r = std::sqrt(1.0 - z * z);
    out.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return out;
}

double share_visited(const std::vector<Vector3>& visited) {
  int seen = 0;
  const double cosine = std::cos(kNear);
  for (const Vector3& d : even_directions()) {
    seen += std::ranges::any_of(visited, [&](const Vector3& v) { return v.dot(d) > cosine; });
  }
  return double(seen) / kDirections;
}

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    out += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  return out;
}

std::vector<std::string> missing_of(const Coverage& c) {
  std::vector<std::string> out, up, turns;
  for (int i = 0; i < 6; ++i) {
    if (c.nearest_up_rad[std::size_t(i)] < kSeen) continue;
    up.push_back(kAxes[i]);
  }
  for (int i = 0; i < 3; ++i) {
    if (c.turned_rad[i] >= kEnoughTurn) continue;
    turns.push_back(fmt::format("{} ({:.0f} deg in all)", kAxes[2 * i], c.turned_rad[i] / kDegree));
  }
  if (!up.empty()) {
    out.push_back(
        fmt::format("Its {} {} never pointed up: hold the sensor so, too, and turn it "
                    "about the vertical there.",
                    listed(up), up.size() == 1 ? "axis" : "axes"));
  }
  if (!turns.empty()) {
    out.push_back(
        fmt::format("It hardly turned about its {}: turn it half a turn to and fro about "
                    "each, several times.",
                    listed(turns)));
  }
  return out;
}

}  // namespace

Coverage coverage_of(const std::vector<const Recording*>& parts, const std::vector<Rot3>& nRb,
                     double dip_rad, const Vector3& gyr_bias) {
  Coverage out;
  std::vector<Vector3> up, field;
  const Vector3 b = unit_field(dip_rad);
  for (const Rot3& R : nRb) {
    up.push_back(R.unrotate(Vector3(Vector3::UnitZ())));
    field.push_back(R.unrotate(b));
  }
  out.up = share_visited(up);
  out.field = share_visited(field);
  for (int i = 0; i < 6; ++i) {
    double cosine = -1.0;
    for (const Vector3& v : up) cosine = std::max(cosine, v.dot(axis(i)));
    out.nearest_up_rad[std::size_t(i)] = std::acos(std::clamp(cosine, -1.0, 1.0));
  }
  for (const Recording* part : parts) {
    const VectorSeries& gyr = part->gyr;
    for (std::size_t k = 0; k + 1 < gyr.size(); ++k) {
      const Vector3 rate = gyr.v[k] - gyr_bias;
      out.turned_rad += rate.cwiseAbs() * (gyr.t[k + 1] - gyr.t[k]);
      out.fastest_rad_s = std::max(out.fastest_rad_s, rate.norm());
    }
  }
  out.missing = missing_of(out);
  return out;
}

}  // namespace magimu
