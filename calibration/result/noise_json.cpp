// SPDX-License-Identifier: BSD-3-Clause
// "magimu-noise/1": written and read.
#include <cmath>

#include "calibration/rest_noise/noise_at_rest.h"
#include "recording/data/error.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

using Json = nlohmann::ordered_json;

Json bounded(const Bounded& b) {
  return {{"value", b.value}, {"low", b.low}, {"high", b.high}, {"determined", b.determined}};
}

Json axis_json(const AxisNoise& a) {
  Json points = Json::array();
  for (const AllanPoint& p : a.points) {
    points.push_back(
        {{"tau_s", p.tau_s}, {"deviation", p.deviation}, {"low", p.low}, {"high", p.high}});
  }
  return {{"white", bounded(a.white)},
          {"bias_instability", bounded(a.bias_instability)},
          {"random_walk", bounded(a.random_walk)},
          {"sample_density", a.sample_density},
          {"lowest", {{"tau_s", a.lowest.tau_s}, {"deviation", a.lowest.deviation}}},
          {"still_falling", a.still_falling},
          {"allan", points}};
}

}  // namespace

Json to_json(const RestNoise& noise) {
  Json out;
  out["format"] = "magimu-noise/1";
  out["recording"] = noise.recording;
  out["span_s"] = {noise.span.begin_s, noise.span.end_s};
  const NoiseDensities d = noise.densities();
  out["noise"] = {{"acc", d.acc}, {"gyro", d.gyr}, {"mag", d.mag}};
  for (const SensorNoise& s : noise.sensors) {
    Json axes;
    for (std::size_t i = 0; i < 3; ++i) axes[std::string(1, "xyz"[i])] = axis_json(s.axes[i]);
    out["sensors"].push_back({{"name", s.name},
                              {"unit", s.unit},
                              {"samples", s.samples},
                              {"interval_s", s.interval_s},
                              {"axes", axes}});
  }
  out["notes"] = noise.notes;
  return out;
}

NoiseDensities read_noise(const std::string& path) {
  constexpr const char* kRemedy =
      "name a file that `magimu allan -o` wrote, or give the three densities as numbers";
  const Json json = Json::parse(read_file(path), nullptr, false);
  if (!json.is_object() || !json.contains("format") || json["format"] != "magimu-noise/1") {
    throw InputError(path, 0, 0, "this is no noise file (format magimu-noise/1)", kRemedy);
  }
  const Json noise = json.value("noise", Json::object());
  NoiseDensities out;
  for (const auto& [name, value] :
       {std::pair<const char*, double*>{"acc", &out.acc}, {"gyro", &out.gyr}, {"mag", &out.mag}}) {
    const auto it = noise.find(name);
    if (it == noise.end() || !it->is_number() || !(it->get<double>() > 0.0)) {
      throw InputError(path, 0, 0, std::string("noise.") + name + " is not a positive number",
                       kRemedy);
    }
    *value = it->get<double>();
  }
  return out;
}

}  // namespace magimu
