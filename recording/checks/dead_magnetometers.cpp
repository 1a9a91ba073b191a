// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/dead_magnetometers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "recording/checks/gate.h"
#include "recording/checks/quality_checks.h"
#include "recording/data/set_aside.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

// A driver that has no reading writes one impossible value: so often the same, and so much longer
// than the others.
constexpr double kOftenTheSame = 0.2, kTooLong = 3.0;
// Correlation of neighbouring readings: of a magnetometer that reads noise alone at most the one,
// while another one's, in the same field, is at least the other.
constexpr double kNoise = 0.5, kField = 0.9;

std::optional<std::string> impossible_value(const std::string& name, const VectorSeries& mag) {
  std::map<std::array<double, 3>, std::size_t> counts;
  for (const Vector3& v : mag.v) {
    if (v.allFinite()) ++counts[{v[0], v[1], v[2]}];
  }
  const auto most = std::ranges::max_element(counts, {}, [](const auto& c) { return c.second; });
  if (most == counts.end()) return std::nullopt;
  const double share = double(most->second) / double(mag.size());
  if (share < kOftenTheSame) return std::nullopt;
  const Vector3 value(most->first[0], most->first[1], most->first[2]);
  std::vector<double> others;
  for (const Vector3& v : mag.v) {
    if (v != value) others.push_back(v.norm());
  }
  if (others.empty() || value.norm() < kTooLong * quantile(others, 0.5)) return std::nullopt;
  return fmt::format(
      "{} reads ({:.6g}, {:.6g}, {:.6g}) uT in {:.0f} % of its samples, which is no "
      "measurement",
      name, value[0], value[1], value[2], 100.0 * share);
}

// The largest of its axes.
double correlation_of_neighbours(const VectorSeries& mag) {
  double largest = 0.0;
  Vector3 mean = Vector3::Zero();
  for (const Vector3& v : mag.v) mean += v / double(mag.size());
  for (int axis = 0; axis < 3; ++axis) {
    double products = 0.0, squares = 0.0;
    for (std::size_t k = 0; k < mag.size(); ++k) {
      const double x = mag.v[k][axis] - mean[axis];
      squares += x * x;
      if (k > 0) products += x * (mag.v[k - 1][axis] - mean[axis]);
    }
    if (squares > 0.0) largest = std::max(largest, products / squares);
  }
  return largest;
}

// Where others fit a unit, one that does not has another; where others turn in the field, one whose
// neighbouring readings have nothing to do with each other does not see it.
std::optional<DeadMagnetometer> unlike_the_others(const Recording& r, std::size_t m,
                                                  const std::vector<Issue>& units,
                                                  const std::vector<double>& correlations) {
  const std::string& name = r.mag_names[m];
  const double best = *std::ranges::max_element(correlations);
  if (correlations[m] < kNoise && best > kField) {
    return DeadMagnetometer{
        name,
        fmt::format("{} reads noise alone: neighbouring readings have nothing to "
                    "do with each other, however it is turned",
                    name),
        "check its wires and its driver"};
  }
  const auto wrong = [&](const std::string& of) {
    return std::ranges::find_if(units, [&](const Issue& issue) {
      return issue.sensor == of && issue.kind == "unit" && issue.severity == Severity::kFatal;
    });
  };
  const bool others_fit = std::ranges::any_of(
      r.mag_names, [&](const std::string& of) { return wrong(of) == units.end(); });
  if (wrong(name) != units.end() && others_fit) {
    return DeadMagnetometer{name, wrong(name)->problem,
                            "the others have the usual unit: let the logger write all in one"};
  }
  return std::nullopt;
}

void erase_magnetometer(Recording& recording, const std::string& name) {
  const auto at = std::ranges::find(recording.mag_names, name);
  if (at == recording.mag_names.end()) return;
  recording.mag.erase(recording.mag.begin() + (at - recording.mag_names.begin()));
  recording.mag_names.erase(at);
  std::erase_if(recording.set_aside, [&](const SetAside& s) { return s.sensor == name; });
}

}  // namespace

std::string left_out_sentence(const std::string& name, const std::string& problem) {
  std::string why = problem;
  if (why.starts_with(name + ": ")) {
    why = why.substr(name.size() + 2);
  } else if (why.starts_with(name + " ")) {
    why.replace(0, name.size(), "it");
  }
  return fmt::format("{} is left out: {}", name, why);
}

std::vector<DeadMagnetometer> dead_magnetometers(const Recording& given) {
  std::vector<DeadMagnetometer> out;
  if (given.mag.size() < 2 || given.mag_names.size() != given.mag.size()) return out;
  const std::optional<Recording> kept = gated(given);
  const Recording& recording = kept ? *kept : given;
  const std::vector<Issue> units = check_units(recording);
  std::vector<double> correlations;
  for (const VectorSeries& mag : recording.mag) {
    correlations.push_back(correlation_of_neighbours(mag));
  }
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    const std::string& name = recording.mag_names[m];
    if (recording.mag[m].size() < kFewestToJudge) {
      out.push_back({name, fmt::format("{} has {} samples", name, recording.mag[m].size()),
                     "check its wires and the logger"});
      continue;
    }
    const SetAside* most = nullptr;
    double lost = 0.0;
    for (const SetAside& s : recording.set_aside) {
      if (s.sensor != name) continue;
      lost += lost_share(s);
      if (most == nullptr || s.count > most->count) most = &s;
    }
    if (lost > kSetAsideMost) {
      out.push_back({name, sentence(*most), remedy(*most)});
      continue;
    }
    if (const std::optional<std::string> problem = impossible_value(name, recording.mag[m])) {
      out.push_back({name, *problem, "leave the fields empty where the sensor has no sample"});
      continue;
    }
    const std::vector<Issue> issues = check_stuck({name, &recording.mag[m]}, recording.gyr, false);
    const auto fatal = std::ranges::find(issues, Severity::kFatal, &Issue::severity);
    if (fatal != issues.end()) {
      out.push_back({name, fatal->problem, fatal->remedy});
    } else if (const auto unlike = unlike_the_others(recording, m, units, correlations)) {
      out.push_back(*unlike);
    }
  }
  if (out.size() == recording.mag.size()) out.clear();
  return out;
}

void leave_out_dead_magnetometers(std::span<Recording> recordings) {
  std::map<std::string, std::string> died_in;  // a recording of each
  std::vector<std::vector<DeadMagnetometer>> dead;
  for (const Recording& recording : recordings) {
    dead.push_back(dead_magnetometers(recording));
    for (const DeadMagnetometer& d : dead.back()) died_in.emplace(d.name, recording.name);
  }
  if (died_in.empty()) return;
  const bool none_left = std::ranges::any_of(recordings, [&](const Recording& recording) {
    return std::ranges::all_of(recording.mag_names,
                               [&](const std::string& name) { return died_in.contains(name); });
  });
  if (none_left) return;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    Recording& recording = recordings[i];
    for (const auto& [name, where] : died_in) {
      if (std::ranges::find(recording.mag_names, name) == recording.mag_names.end()) continue;
      erase_magnetometer(recording, name);
      const auto own = std::ranges::find(dead[i], name, &DeadMagnetometer::name);
      recording.cautions.push_back(
          own != dead[i].end()
              ? left_out_sentence(name, own->problem) + "; " + own->remedy
              : fmt::format("{} is left out: it does not measure in {}; the others are "
                            "calibrated without it",
                            name, where));
    }
  }
}

}  // namespace magimu
