// SPDX-License-Identifier: BSD-3-Clause
#include "apps/stream/stream_json.h"

#include <cstdio>

#include "calibration/result/calibration_json.h"

namespace magimu::apps {
namespace {

using Json = nlohmann::ordered_json;

Json theta_json(const std::optional<Calibration>& theta) {
  if (!theta) return nullptr;
  Json out = parameters_json(*theta);
  out["undetermined"] = theta->undetermined;
  out["trust"] = {{"verdict", to_string(theta->trust.verdict)}, {"reasons", theta->trust.reasons}};
  return out;
}

Json target_json(const std::vector<TargetProgress>& target) {
  Json out = Json::array();
  for (const TargetProgress& t : target) {
    out.push_back({{"name", t.label}, {"sigma", t.sigma}, {"limit", t.limit}, {"unit", t.unit}});
  }
  return out;
}

Json issues_json(const std::vector<Issue>& issues) {
  Json out = Json::array();
  for (const Issue& issue : issues) {
    out.push_back({{"kind", issue.kind},
                   {"sensor", issue.sensor},
                   {"axis", issue.axis < 0 ? Json(nullptr) : Json(axis_name(issue.axis))},
                   {"severity", to_string(issue.severity)},
                   {"problem", issue.problem},
                   {"remedy", issue.remedy}});
  }
  return out;
}

Json change_json(const std::optional<SensorChange>& change) {
  if (!change) return nullptr;
  const SensorChange& d = *change;
  const auto name = [](int sensor) -> std::string {
    if (sensor < 2) return sensor == 0 ? "accelerometer" : "gyroscope";
    return "magnetometers[" + std::to_string(sensor - 2) + "]";
  };
  Json others = Json::array();
  for (const int other : d.also_likely) others.push_back(name(other));
  return {{"sensor", name(d.sensor)}, {"also_likely", others},
          {"since_s", d.since_s},     {"between_s", {d.earliest_s, d.latest_s}},
          {"stays", d.stays},         {"size", {d.size[0], d.size[1], d.size[2]}},
          {"log_odds", d.log_odds},   {"advice", advice(d)}};
}

}  // namespace

std::string stream_line(const StreamStatus& status, const std::vector<std::string>& events) {
  const StreamUpdate none;  // before the first window
  const StreamUpdate& u = status.update ? *status.update : none;
  Json line;
  line["t"] = status.update ? Json(u.t) : Json(nullptr);
  line["samples"] = u.samples;
  line["phase"] = to_string(u.phase);
  line["theta"] = theta_json(u.theta);
  line["window"] = {{"nis", u.window.nis},
                    {"dof", u.window.dof},
                    {"p_value", u.window.p_value},
                    {"used", u.window.used}};
  line["guidance"] = status.guidance();
  line["missing"] = u.missing;
  line["latency_us"] = status.latency_us;
  line["target"] = target_json(status.target);
  line["events"] = events;
  line["headline"] = status.headline();
  line["issues"] = issues_json(status.issues);
  line["checks"] = checks_json(u.checks);
  line["flagged_windows"] = u.flagged_windows;
  line["sensor_change"] = change_json(u.sensor_change);
  line["source"] = status.silent ? "silent" : "flowing";
  line["malformed"] = status.lines.malformed;
  line["out_of_order"] = status.lines.out_of_order;
  line["lost_bytes"] = status.lost_bytes;
  return line.dump();
}

void JsonLines::window(const StreamStatus& status, const std::vector<std::string>& events) {
  const std::string line = stream_line(status, events) + "\n";
  const bool written = std::fwrite(line.data(), 1, line.size(), stdout) == line.size();
  if (!written || std::fflush(stdout) != 0) closed_();
}

}  // namespace magimu::apps
