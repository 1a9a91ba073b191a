// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/testable.h"

#include <fmt/format.h>

#include <algorithm>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

constexpr const char* kInNoiseOfArrays = "mag_coupling";

// Of an effect that needs positions, where none are given: what is looked for all the same.
std::string looked_for_without(const Effect& effect, const Stage& stage) {
  if (effect.description().needs != "pos") return "";
  if (effect.name() == "stationary_source") {
    return ", to say where it is; excursions of the field, as near one, are looked for without";
  }
  return is_moved(stage.spec().motion)
             ? ", to say its size; that the field differs from place to place is looked for over "
               "the estimated positions (field departure)"
             : "";
}

constexpr double kVaries = 1e-3;  // m, deg C, A: a column that changes by less is constant

// Does a column vary at all, in the parts of all recordings together?
bool varies(const std::vector<const Recording*>& recordings, const std::string& column) {
  if (column == "pos") {
    return std::ranges::any_of(recordings, [](const Recording* r) {
      return r->pos && std::ranges::any_of(r->pos->v, [&](const Vector3& p) {
               return (p - r->pos->v.front()).norm() > kVaries;
             });
    });
  }
  double least = INFINITY, most = -INFINITY;
  for (const Recording* r : recordings) {
    for (const double value : r->aux.at(column).v) {
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  return most - least > kVaries;
}

bool present(const Recording& r, const std::string& column) {
  return column == "pos" ? r.pos.has_value() : r.aux.contains(column);
}

}  // namespace

std::string reason_untested(const Effect& effect, const std::vector<const Recording*>& recordings,
                            const Stage& stage) {
  if (effect.name() == kInNoiseOfArrays) return "is looked for in the noise of arrays";
  const Effect::Description& d = effect.description();
  if (!d.needs.empty()) {
    const bool pos = d.needs == "pos";
    const std::string shown = pos ? "columns pos_x, pos_y, pos_z" : "column " + d.needs;
    for (const Recording* r : recordings) {
      if (!present(*r, d.needs)) return "needs the " + shown + looked_for_without(effect, stage);
    }
    if (!varies(recordings, d.needs)) {
      return fmt::format("the {} {} not vary", shown, pos ? "do" : "does");
    }
  }
  if (d.rotation_only && is_moved(stage.spec().motion)) {
    return "the hand's motion, which is estimated, takes up whatever it adds";
  }
  const bool of_time = effect.with_terms(1) != nullptr || effect.name() == "stationary_source";
  if (of_time && recordings.size() > 1) {
    const bool of_one = std::ranges::all_of(recordings, [&](const Recording* r) {
      return r == recordings[0] || r->continues_previous;
    });
    return of_one ? "is tested in recordings without long gaps only"
                  : "is tested in single recordings only";
  }
  return "";
}

int count_looked_for() {
  return int(std::ranges::count_if(
      effect_catalogue(), [](const auto& effect) { return effect->name() != kInNoiseOfArrays; }));
}

std::vector<std::shared_ptr<const Effect>> testable_effects(
    const std::vector<const Recording*>& recordings, const Stage& stage) {
  constexpr int kWalkTerms = 12;
  std::vector<std::shared_ptr<const Effect>> out;
  for (const auto& effect : effect_catalogue()) {
    const std::string& name = effect->name();
    const bool searched = is_change(name) || name == "stationary_source" ||
                          name == "mains_interference" || name == "mag_own_clock";
    if (searched) continue;
    if (!reason_untested(*effect, recordings, stage).empty()) continue;
    out.push_back(name == "gyro_bias_drift" ? make_gyro_bias_walk(kWalkTerms, 1.0) : effect);
  }
  return out;
}

}  // namespace magimu
