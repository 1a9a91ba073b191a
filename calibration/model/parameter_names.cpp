// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/model/parameter_names.h"

#include <fmt/format.h>

#include "calibration/model/extension.h"

#include "calibration/motion/nodes.h"
#include "factors/keys.h"

namespace magimu {

std::string time_offset_name(int magnetometer) {
  return fmt::format("magnetometers[{}].time_offset_s", magnetometer);
}

std::string gyr_matrix_name(int entry) {
  return fmt::format("gyroscope.scale_misalignment[{}][{}]", entry / 3, entry % 3);
}

std::string effect_parameter_name(const Effect& effect, int i) {
  return fmt::format("effects.{}.{}", effect.name(),
                     effect.description().parameters[std::size_t(i)].name);
}

EffectParameter effect_parameter_of(const std::string& name) {
  if (name.ends_with("].time_offset_s")) return {"mag_time_offset", "s"};
  if (name.starts_with("gyroscope.scale_misalignment")) return {"gyro_scale_misalignment", "1"};
  constexpr std::string_view kEffects = "effects.";
  if (!name.starts_with(kEffects)) return {};
  const std::string effect =
      name.substr(kEffects.size(), name.find('.', kEffects.size()) - kEffects.size());
  const auto known = find_effect(effect);
  if (!known) return {};
  for (int i = 0; i < known->size(); ++i) {
    if (effect_parameter_name(*known, i) == name)
      return {effect, known->description().parameters[std::size_t(i)].unit};
  }
  return {};
}

std::vector<Key> parameter_keys(int magnetometers, int recordings, const ModelSpec& spec) {
  std::vector<Key> keys{key::acc_bias, key::gyr_bias};
  for (int m = 0; m < magnetometers; ++m) {
    keys.push_back(key::distortion_of(m));
    keys.push_back(key::mag_bias_of(m));
  }
  for (int r = 0; r < recordings; ++r) keys.push_back(dip_of(r));
  for (int m = 0; spec.mag_time_offset && m < magnetometers; ++m) {
    keys.push_back(key::mag_time_offset_of(m));
  }
  if (spec.gyr_matrix) keys.push_back(key::gyr_matrix);
  for (const auto& own : effect_keys(spec.effects)) keys.insert(keys.end(), own.begin(), own.end());
  return keys;
}

std::vector<std::string> parameter_names(int magnetometers, int recordings, const ModelSpec& spec) {
  std::vector<std::string> names;
  for (int i = 0; i < 3; ++i) names.push_back(fmt::format("accelerometer.bias[{}]", i));
  for (int i = 0; i < 3; ++i) names.push_back(fmt::format("gyroscope.bias[{}]", i));
  for (int m = 0; m < magnetometers; ++m) {
    for (int e = 0; e < 9; ++e) {  // the tangent of D runs column by column
      names.push_back(fmt::format("magnetometers[{}].distortion[{}][{}]", m, e % 3, e / 3));
    }
    for (int i = 0; i < 3; ++i) names.push_back(fmt::format("magnetometers[{}].bias[{}]", m, i));
  }
  for (int r = 0; r < recordings; ++r) {
    names.push_back(recordings == 1 ? "field.dip_deg" : fmt::format("fields[{}].dip_deg", r));
  }
  for (int m = 0; spec.mag_time_offset && m < magnetometers; ++m) {
    names.push_back(time_offset_name(m));
  }
  for (int e = 0; spec.gyr_matrix && e < 9; ++e) {
    names.push_back(gyr_matrix_name(e));
  }
  for (const auto& effect : spec.effects) {
    for (int i = 0; i < effect->size(); ++i) names.push_back(effect_parameter_name(*effect, i));
  }
  return names;
}

}  // namespace magimu
