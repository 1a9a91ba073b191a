// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/dead_magnetometers.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "recording/checks/gate.h"
#include "recording/checks/quality_checks.h"
#include "recording/data/set_aside.h"

namespace magimu {
namespace {

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
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    const std::string& name = recording.mag_names[m];
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
    const std::vector<Issue> issues = check_stuck({name, &recording.mag[m]}, recording.gyr, false);
    const auto fatal = std::ranges::find(issues, Severity::kFatal, &Issue::severity);
    if (fatal != issues.end()) out.push_back({name, fatal->problem, fatal->remedy});
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
