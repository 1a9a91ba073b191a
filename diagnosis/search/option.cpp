// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/option.h"

#include <fmt/format.h>

#include <algorithm>

#include "calibration/model/extension.h"
#include "calibration/model/sensed_motion.h"

namespace magimu {
namespace {

// Of parameters: a random process has a density.
int count(const Effect& effect) { return effect.description().random_process ? 1 : effect.size(); }

}  // namespace

double longest_s(const std::vector<const Recording*>& recordings) {
  double longest = 0.0;
  for (const Recording* r : recordings) longest = std::max(longest, r->duration_s());
  return longest;
}

bool among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool contains(const Effect& effect, const std::string& name) {
  return among(effect.description().contains, name);
}

double allowance(const Effect& one, const Effect& other, double gain, double other_gain) {
  if (contains(other, one.name())) return std::max(kDraw, (1.0 - kAsMuch) * other_gain);
  if (contains(one, other.name())) return -std::max(kDraw, (1.0 - kAsMuch) * gain);
  const bool recorded = !one.description().needs.empty();
  if (recorded == other.description().needs.empty()) {
    if (recorded && of_any_time(other)) return kDraw;
    if (!recorded && of_any_time(one)) return -kDraw;
  }
  if (of_any_time(one) && of_any_time(other)) return 0.0;
  const int more = count(one) - count(other);
  return more < 0 ? kDraw : more > 0 ? -kDraw : 0.0;
}

bool is_simpler(const Effect& one, const Effect& other) {
  return one.channel() == other.channel() && one.name() != other.name() &&
         allowance(one, other, 0.0, 0.0) > 0.0;
}

bool replaces(const Effect& effect, const std::string& name) {
  return contains(effect, name) || among(effect.description().same_class, name) ||
         (effect.name() == "stationary_source" && name == effect.name());
}

bool same_class(const Effect& a, const Effect& b) {
  return among(a.description().same_class, b.name()) || among(b.description().same_class, a.name());
}

bool is_lag(const std::string& name) { return name == "mag_time_offset" || name == "mag_lag"; }

bool of_any_time(const Effect& effect) {
  return effect.with_terms(1) != nullptr || is_change(effect.name());
}

bool lasts(const Effect& effect) {
  return !of_any_time(effect) && !effect.description().random_process;
}

VectorSeries residual_without_last(const Stage& stage, int recording, VectorXd& theta) {
  const ModelSpec& spec = stage.spec();
  const Values& values = stage.result().values;
  theta = effect_parameters(values, effect_keys(spec.effects).back());
  VectorSeries out;
  for (std::size_t r = 0; r < stage.plans().size(); ++r) {
    if (stage.plans()[r].field != recording) continue;
    const Recording& corrected = spec.extended[r]->corrected;
    const SensedMotion motion(corrected, stage.plans()[r], spec, values);
    const VectorSeries& mag = corrected.mag.front();
    for (std::size_t k = 0; k < mag.size(); ++k) {
      const SampleState s = motion.state(Sensor::kMag, k);
      out.push_back(mag.t[k], mag.v[k] - s.D * s.b - s.bias + spec.effects.back()->term(s, theta));
    }
  }
  return out;
}

}  // namespace magimu
