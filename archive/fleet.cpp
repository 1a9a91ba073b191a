// SPDX-License-Identifier: BSD-3-Clause
#include "archive/fleet.h"

#include <fmt/format.h>

#include <algorithm>

#include "calibration/result/calibration_json.h"

namespace magimu {
namespace {

using FleetJson = nlohmann::ordered_json;

std::string quoted_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

std::string row_text(const std::vector<std::string>& fields) {
  std::string out;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    out += (i > 0 ? "," : "") + quoted_field(fields[i]);
  }
  return out + "\n";
}

std::string number(double value) { return fmt::format("{:.9g}", value); }

// A parameter's value in the device's file.
double device_value(const Device& device, std::size_t i) {
  return device.history.changes.empty() ? device.joint[Eigen::Index(i)]
                                        : device.at.back()[Eigen::Index(i)];
}

}  // namespace

FleetDevice fleet_device(const Device& device, std::vector<FleetRecording*> rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    FleetRecording& row = *rows[i];
    const Standing& s = device.standing[i];
    const Calibration& c = device.recordings[i].calibration;
    row.calibrated = true;
    row.own_verdict = to_string(c.trust.verdict);
    row.verdict = to_string(s.verdict);
    row.reason = s.reason;
    row.agrees_with = s.agrees_with;
    row.used = s.used;
    row.distance = s.distance;
    row.motion = to_string(c.motion);
    row.strength_uT = c.strength_uT;
    row.strength_sigma_uT = c.strength_sigma_uT;
    row.dip_deg = c.fields.front().dip_rad / kDegree;
    row.hard_iron = c.parameters.mag.front().bias;
    for (int k = 0; k < 3; ++k) {
      row.hard_iron_sigma[k] = c.sigma(fmt::format("magnetometers[0].bias[{}]", k));
    }
  }
  FleetDevice out;
  out.name = device.name;
  out.calibrated = device.recordings.size();
  out.used = device.used.size();
  out.birge = device.birge;
  if (!device.calibration) {
    out.verdict = to_string(Verdict::kNo);
    out.reason =
        "No recording of this device has a fit that could be used; recordings.csv says why.";
    return out;
  }
  const Calibration& c = *device.calibration;
  out.verdict = to_string(c.trust.verdict);
  if (!c.trust.reasons.empty()) out.reason = c.trust.reasons.front();
  out.strength_uT = c.strength_uT;
  out.strength_sigma_uT = c.strength_sigma_uT;
  for (std::size_t i = 0; i < device.history.changes.size(); ++i) {
    const FoundChange& f = device.history.changes[i];
    const std::size_t k = f.change.kind == ChangeKind::kStep ? f.change.at : 0;
    const DeviceRecording& r = device.recordings[device.used[k]];
    const bool step = f.change.kind == ChangeKind::kStep;
    out.changes.push_back({to_string(f.change.kind), device.groups[f.change.group].name,
                           step ? r.shown : "", step ? r.date : "", sentence_of(device, i),
                           f.probability, step ? f.date_probability : 0.0, f.log_bayes_factor,
                           is_clear(f), device.sizes[i]});
  }
  for (std::size_t i = 0; i < c.order.size(); ++i) {
    const auto at = std::ranges::find(device.order, c.order[i]);
    const double value = at == device.order.end()
                             ? c.fields.front().dip_rad / kDegree
                             : device_value(device, std::size_t(at - device.order.begin()));
    out.parameters.push_back({"", c.order[i], value, c.sigma(c.order[i])});
  }
  for (std::size_t k = 0; k < device.used.size(); ++k) {
    for (std::size_t i = 0; i < device.order.size(); ++i) {
      out.parameters.push_back({device.recordings[device.used[k]].shown, device.order[i],
                                device.at[k][Eigen::Index(i)], device.sigma[k][Eigen::Index(i)]});
    }
  }
  return out;
}

std::string recordings_csv(const std::vector<FleetRecording>& rows) {
  std::string out =
      "path,device,place,date,status,verdict,own_verdict,reason,remedy,found,agrees_with,used,"
      "distance_sigma,duration_s,motion,strength_uT,strength_uT_sigma,dip_deg,hard_iron_x_uT,"
      "hard_iron_y_uT,hard_iron_z_uT,hard_iron_x_uT_sigma,hard_iron_y_uT_sigma,"
      "hard_iron_z_uT_sigma,result\n";
  for (const FleetRecording& r : rows) {
    std::vector<std::string> fields{r.path,
                                    r.device,
                                    r.place,
                                    r.date,
                                    r.status,
                                    r.verdict,
                                    r.own_verdict,
                                    r.reason,
                                    r.remedy,
                                    r.found,
                                    r.agrees_with,
                                    r.calibrated ? (r.used ? "1" : "0") : "",
                                    r.calibrated ? number(r.distance) : ""};
    fields.push_back(r.duration_s > 0.0 ? number(r.duration_s) : "");
    fields.push_back(r.motion);
    for (const double v :
         {r.strength_uT, r.strength_sigma_uT, r.dip_deg, r.hard_iron[0], r.hard_iron[1],
          r.hard_iron[2], r.hard_iron_sigma[0], r.hard_iron_sigma[1], r.hard_iron_sigma[2]}) {
      fields.push_back(r.calibrated ? number(v) : "");
    }
    fields.push_back(r.result);
    out += row_text(fields);
  }
  return out;
}

std::string devices_csv(const std::vector<FleetDevice>& devices) {
  std::string out =
      "device,verdict,reason,recordings,calibrated,used,changes,unclear_changes,scatter,strength_"
      "uT,"
      "strength_uT_sigma\n";
  for (const FleetDevice& d : devices) {
    const auto clear = std::ranges::count_if(d.changes, &FleetChange::clear);
    out += row_text({d.name, d.verdict, d.reason, std::to_string(d.recordings),
                     std::to_string(d.calibrated), std::to_string(d.used), std::to_string(clear),
                     std::to_string(std::ssize(d.changes) - clear), number(d.birge),
                     d.used > 0 ? number(d.strength_uT) : "",
                     d.used > 0 ? number(d.strength_sigma_uT) : ""});
  }
  return out;
}

std::string changes_csv(const std::vector<FleetDevice>& devices) {
  std::string out =
      "device,kind,what,recording,date,size,sigma,unit,probability,date_probability,"
      "log_bayes_factor,sentence\n";
  for (const FleetDevice& d : devices) {
    for (const FleetChange& c : d.changes) {
      out += row_text({d.name, c.kind, c.what, c.recording, c.date, number(c.size.value),
                       number(c.size.sigma), c.size.unit, number(c.probability),
                       c.recording.empty() ? "" : number(c.date_probability),
                       number(c.log_bayes_factor), c.sentence});
    }
  }
  return out;
}

std::string device_json(const Device& device) {
  FleetJson out;
  if (device.calibration) out = to_json(*device.calibration);
  out["device"] = device.name;
  if (device.calibration) {
    FleetJson& fit = out["fit"];  // of one recording: says nothing of the device
    fit = {{"samples", 0}, {"nodes", 0}, {"seconds", 0.0}};
    for (const std::size_t i : device.used) {
      fit["samples"] = fit["samples"].get<int>() + device.recordings[i].calibration.samples;
    }
    out["scatter"] = device.birge;
    for (const char* of_one_recording : {"residuals", "checks", "disturbances", "set_aside"}) {
      out.erase(of_one_recording);
    }
  }
  out["recordings"] = FleetJson::array();
  for (std::size_t i = 0; i < device.recordings.size(); ++i) {
    const DeviceRecording& r = device.recordings[i];
    const Standing& s = device.standing[i];
    out["recordings"].push_back({{"path", r.shown},
                                 {"place", r.place},
                                 {"date", r.date},
                                 {"result", r.name},
                                 {"verdict", to_string(s.verdict)},
                                 {"own_verdict", to_string(r.calibration.trust.verdict)},
                                 {"reason", s.reason},
                                 {"agrees_with", s.agrees_with},
                                 {"used", s.used},
                                 {"why_not", s.why_not},
                                 {"distance_sigma", s.distance}});
  }
  out["changes"] = FleetJson::array();
  for (std::size_t i = 0; i < device.history.changes.size(); ++i) {
    const FoundChange& f = device.history.changes[i];
    const ChangeSize& s = device.sizes[i];
    FleetJson c = {{"kind", to_string(f.change.kind)},
                   {"what", device.groups[f.change.group].name},
                   {"size", {{"value", s.value}, {"sigma", s.sigma}, {"unit", s.unit}}},
                   {"sentence", sentence_of(device, i)},
                   {"probability", f.probability},
                   {"log_bayes_factor", f.log_bayes_factor},
                   {"size_in_sigmas", f.change.size}};
    if (f.change.kind == ChangeKind::kStep) {
      c["recording"] = device.recordings[device.used[f.change.at]].shown;
      c["date"] = device.recordings[device.used[f.change.at]].date;
      c["date_probability"] = f.date_probability;
    }
    out["changes"].push_back(std::move(c));
  }
  FleetJson history = {{"order", device.order}, {"at", FleetJson::array()}};
  for (std::size_t k = 0; k < device.used.size(); ++k) {
    FleetJson value = FleetJson::array(), sigma = FleetJson::array();
    for (const double v : device.at[k]) value.push_back(v);
    for (const double v : device.sigma[k]) sigma.push_back(v);
    history["at"].push_back({{"recording", device.recordings[device.used[k]].shown},
                             {"value", value},
                             {"sigma", sigma}});
  }
  out["history"] = history;
  return out.dump(1, ' ', false, FleetJson::error_handler_t::replace) + "\n";
}

}  // namespace magimu
