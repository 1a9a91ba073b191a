// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/unit_issues.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "recording/data/units.h"
#include "statistics/quantiles.h"

namespace magimu {

double file_unit(const Recording& r, const std::string& quantity) {
  const auto found = r.file_units.find(quantity);
  return found == r.file_units.end() ? 1.0 : found->second;
}

std::string scaled_in_memory(const std::string& quantity, double factor) {
  return fmt::format(" (in memory: multiply {} by {:.6g})", quantity, factor);
}

Issue unit_issue(const Recording& r, const std::string& sensor, const std::string& quantity,
                 const std::string& problem, const std::string& unit) {
  const std::optional<double> in_ours = unit_in_ours(quantity, unit.substr(0, unit.find(' ')));
  const bool one = in_ours && unit.find(" or ") == std::string::npos;
  const std::string memory = one ? scaled_in_memory(sensor, *in_ours / file_unit(r, quantity))
                                 : " (in memory: multiply " + sensor + " by it)";
  return {"unit",  sensor,
          -1,      Severity::kFatal,
          0.0,     0.0,
          problem, fmt::format("give the file's unit: --unit {}={}{}", quantity, unit, memory)};
}

std::string unit_text(const std::string& quantity, double in_ours, double near) {
  constexpr std::pair<const char*, const char*> kNames[] = {
      {"acc", "g"},      {"acc", "mg"},    {"acc", "m/s^2"},  {"gyr", "deg/s"},
      {"gyr", "mdeg/s"}, {"gyr", "rad/s"}, {"gyr", "mrad/s"}, {"mag", "uT"},
      {"mag", "gauss"},  {"mag", "mG"},    {"mag", "nT"},     {"mag", "T"}};
  for (const auto& [of, name] : kNames) {
    if (quantity != of) continue;
    if (std::abs(in_ours / *unit_in_ours(of, name) - 1.0) < near) return name;
  }
  return fmt::format("{:.6g}", in_ours);
}

bool is_whole(const VectorSeries& s, double file_unit) {
  return std::ranges::all_of(s.v, [&](const Vector3& v) {
    return (v / file_unit).array().round().matrix().isApprox(v / file_unit, 1e-9);
  });
}

Quietest quietest_of(const VectorSeries& s) {
  constexpr std::size_t kStretch = 20, kFewest = 3;  // samples in a stretch; stretches
  constexpr double kStretchSeconds = 0.2;  // of a stretch, at least: a hand's motion shows in it
  constexpr double kShare = 0.04;          // of all stretches: the quietest
  constexpr double kAsQuiet = 4.0, kScatterAtRest = 0.05;
  const auto in_time = std::size_t(kStretchSeconds * s.rate_hz());
  const std::size_t size = std::clamp(in_time, kStretch, std::max(kStretch, s.size() / 8));
  // Of each stretch: squared scatter of a sample, length of the mean.
  std::vector<std::pair<double, double>> stretches;
  for (std::size_t k = 0; k + size <= s.size(); k += size) {
    Vector3 mean = Vector3::Zero();
    double squares = 0.0;
    for (std::size_t i = k; i < k + size; ++i) mean += s.v[i] / double(size);
    for (std::size_t i = k; i < k + size; ++i) squares += (s.v[i] - mean).squaredNorm();
    stretches.emplace_back(squares / double(size), mean.norm());
  }
  if (stretches.empty()) return {};
  std::ranges::sort(stretches);
  const std::size_t few = std::min(kFewest, stretches.size());
  const auto most = std::max(few, std::size_t(kShare * double(stretches.size())));
  std::vector<double> lengths;
  for (std::size_t i = 0; i < most; ++i) {
    // With few rests the 4 % reach into the motion.
    if (i >= few && stretches[i].first > kAsQuiet * stretches[few - 1].first) break;
    lengths.push_back(stretches[i].second);
  }
  const double length = median(std::move(lengths));
  return {length, std::sqrt(stretches[few - 1].first) < kScatterAtRest * length};
}

}  // namespace magimu
