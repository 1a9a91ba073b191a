// SPDX-License-Identifier: BSD-3-Clause
// A calibration file's names for the truth of a simulation: truth_json.h.
#include "sim/truth_json.h"

#include "graph/json_numbers.h"
#include "sim/draws/parameters.h"

namespace magimu {
namespace {

nlohmann::json to_json(const HiddenEffect& effect) {
  nlohmann::json json{{"name", effect.name}, {"parameters", nlohmann::json::array()}};
  if (effect.on_noise) json["channel"] = to_string(effect.channel);
  for (const HiddenEffect::Parameter& p : effect.parameters) {
    json["parameters"].push_back({{"name", p.name}, {"value", p.value}, {"unit", p.unit}});
  }
  return json;
}

}  // namespace

nlohmann::json to_json(const SimulationTruth& truth, const SimulationOptions& options) {
  const SensorParameters& parameters = truth.parameters;
  nlohmann::json json;
  json["format"] = "magimu-truth/1";
  json["seed"] = options.seed;
  json["rate_hz"] = options.rate_hz;
  json["mag_ratio"] = options.mag_ratio;
  json["motion"] = to_string(truth.p.empty() ? options.motion : SimulatedMotion::kHandHeld);
  json["gravity"] = truth.gravity;
  json["accelerometer"]["bias"] = json_numbers<nlohmann::json>(parameters.acc_bias);
  json["gyroscope"]["bias"] = json_numbers<nlohmann::json>(parameters.gyr_bias);
  const std::vector<std::string> names = magnetometer_names(parameters.mag.size());
  json["magnetometers"] = nlohmann::json::array();
  for (std::size_t i = 0; i < parameters.mag.size(); ++i) {
    json["magnetometers"].push_back(
        {{"name", names[i]},
         {"distortion", json_numbers<nlohmann::json>(parameters.mag[i].distortion)},
         {"bias", json_numbers<nlohmann::json>(parameters.mag[i].bias)}});
  }
  json["field"] = {{"dip_deg", parameters.dip_rad / kDegree}, {"strength_uT", truth.strength_uT}};
  json["noise"] = {{"acc", truth.noise.acc}, {"gyro", truth.noise.gyr}, {"mag", truth.noise.mag}};
  if (options.room) json["room"] = *options.room;
  json["effects"] = nlohmann::json::array();
  for (const HiddenEffect& effect : truth.effects) json["effects"].push_back(to_json(effect));
  return json;
}

}  // namespace magimu
