// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/survey_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/say/numbers.h"
#include "calibration/trust/check_axes.h"
#include "graph/json_numbers.h"
#include "graph/sensor.h"
#include "recording/data/axes.h"

namespace magimu::apps {
namespace {

std::string sensors_text(const Survey& s) {
  std::string out = fmt::format("{:<8} {:>8} {:>9} {:>13} {:>16}   {}\n", "Sensor", "samples",
                                "rate", "longest gap", "largest reading", "noise at rest");
  for (const SensorSurvey& x : s.sensors) {
    const std::string noise =
        x.noise_density > 0.0
            ? fmt::format("{:.3g} {}/sqrt(Hz)", x.noise_density, unit_of(sensor_named(x.name)))
            : "-";
    out += fmt::format("{:<8} {:>8} {:>6} Hz {:>10.1f} ms {:>16}   {}\n", x.name, x.samples,
                       fmt::format("{:.4g}", x.rate_hz), 1e3 * x.longest_interval_s,
                       fmt::format("{:.4g} {}", x.largest, unit_of(sensor_named(x.name))), noise);
  }
  return out;
}

std::string rests_text(const Survey& s) {
  const bool unit_unknown = std::ranges::any_of(
      s.issues, [](const Issue& i) { return i.kind == "unit" && i.severity == Severity::kFatal; });
  if (unit_unknown) return "Rests: they cannot be told before the units are known.\n";
  if (s.rests.empty()) {
    return "Rests: none. Lay the sensor down for three seconds before and after: that gives the "
           "noise and\n  the gyroscope's bias.\n";
  }
  double sum = 0.0;
  std::string list;
  for (std::size_t i = 0; i < s.rests.size(); ++i) {
    sum += s.rests[i].length_s();
    if (i < 5) {
      list +=
          fmt::format("{}{:.1f}-{:.1f}", i > 0 ? ", " : "", s.rests[i].begin_s, s.rests[i].end_s);
    }
  }
  if (s.rests.size() > 5) list += fmt::format(" and {} more", s.rests.size() - 5);
  std::string out = fmt::format("Rests: {}, {:.1f} s in all ({} s)\n", s.rests.size(), sum, list);
  if (s.gyr_bias_at_rest) {
    const Vector3& b = *s.gyr_bias_at_rest;
    out += fmt::format("  gyroscope there: {:.5f} {:.5f} {:.5f} rad/s\n", b[0], b[1], b[2]);
  }
  return out;
}

std::string motion_text(const Survey& s) {
  const Coverage& c = s.coverage;
  return fmt::format(
      "Motion: about x, y, z it turned {:.1f}, {:.1f}, {:.1f} times around in all, {:.0f} deg/s at "
      "the fastest\n"
      "  up pointed to {:.0f} % of all directions of the sensor, the field to {:.0f} %\n",
      c.turned_rad[0] / (2.0 * M_PI), c.turned_rad[1] / (2.0 * M_PI),
      c.turned_rad[2] / (2.0 * M_PI), c.fastest_rad_s / kDegree, 100.0 * c.up, 100.0 * c.field);
}

std::string field_text(const Survey& s) {
  if (s.hardly_turned()) return "";
  std::string out = fmt::format(
      "Field: about {:.0f} uT, dip about {:+.0f} deg; the readings lie on one ellipsoid to {:.2g} "
      "uT "
      "({:.1f} % of it)\n",
      s.strength_uT, s.dip_rad / kDegree, s.ellipsoid_rms_uT,
      100.0 * s.ellipsoid_rms_uT / s.strength_uT);
  if (s.disturbed()) {
    out +=
        "  That is far: a magnet or iron came near or was attached for a while, or the field "
        "differs from\n  place to place. magimu diagnose says which; or record again, far from "
        "iron.\n";
  }
  return out;
}

std::string largest_sigma(const Survey& s, const std::string& prefix, int n, double scale) {
  double largest = 0.0;
  for (int i = 0; i < n; ++i) {
    largest = std::max(largest, s.sigma(n > 1 ? fmt::format("{}[{}]", prefix, i) : prefix));
  }
  return fmt::format("{:.2g}", scale * largest);
}

std::string expected_text(const Survey& s) {
  std::string out = fmt::format(
      "What it can determine (motion model {}; one standard deviation of white noise as at rest,\n"
      "worst axis; real sensors: several times as much):\n",
      to_string(s.motion));
  const auto line = [&out](const char* what, const std::string& value, const std::string& unit) {
    out += fmt::format("  {:<30} {:>9} {}\n", what, value, unit);
  };
  for (std::size_t m = 0; m + 2 < s.sensors.size(); ++m) {
    const std::string mag = fmt::format("magnetometers[{}]", m), name = s.sensors[m + 2].name;
    line(fmt::format("{} bias o_m", name).c_str(), largest_sigma(s, mag + ".bias", 3, 1.0), "uT");
    double worst = 0.0;
    for (int i = 0; i < 9; ++i) {
      worst = std::max(worst, s.sigma(fmt::format("{}.distortion[{}][{}]", mag, i / 3, i % 3)));
    }
    line(fmt::format("{} distortion D", name).c_str(), fmt::format("{:.2g}", worst),
         s.hardly_turned()
             ? "uT"
             : fmt::format("uT ({:.2g} % of the field)", 100.0 * worst / s.strength_uT));
  }
  line("accelerometer bias o_a", largest_sigma(s, "accelerometer.bias", 3, 1.0), "m/s^2");
  line("gyroscope bias o_w", largest_sigma(s, "gyroscope.bias", 3, 1.0), "rad/s");
  line("dip", largest_sigma(s, "field.dip_deg", 1, 1.0), "deg");
  for (const std::string& u : s.undetermined) out += "  not at all: " + u + "\n";
  return out;
}

std::string issues_text(const Survey& s) {
  if (s.issues.empty()) return "Checks: nothing found.\n";
  std::string out = "Checks:\n";
  for (const Issue& issue : s.issues) {
    std::string text = issue.text();
    text.front() = char(std::toupper(text.front()));
    out += fmt::format("  {:<8} {}\n", to_string(issue.severity), text);
  }
  return out;
}

nlohmann::json issue_json(const Issue& issue) {
  nlohmann::json j{
      {"kind", issue.kind},       {"sensor", issue.sensor}, {"severity", to_string(issue.severity)},
      {"begin_s", issue.begin_s}, {"end_s", issue.end_s},   {"problem", issue.problem},
      {"remedy", issue.remedy}};
  if (issue.axis >= 0) j["axis"] = std::string(1, "xyz"[issue.axis]);
  return j;
}

nlohmann::json mounting_json(const Mounting& m) {
  const char* status = m.status == MountingStatus::kConsistent ? "consistent"
                       : m.status == MountingStatus::kTurned   ? "turned"
                                                               : "undecided";
  nlohmann::json j{{"status", status},
                   {"sentence", m.sentence},
                   {"fits", nlohmann::json::array()},
                   {"findings", nlohmann::json::array()}};
  for (const AxesFit& fit : m.fits) {
    j["fits"].push_back({{"sensor", fit.sensor},
                         {"ways_that_fit", fit.gyr_axes.size()},
                         {"rms_deg", fit.rms_rad / kDegree},
                         {"rms_as_they_are_deg", fit.rms_straight_rad / kDegree}});
  }
  for (const AxesFinding& f : m.findings) {
    nlohmann::json finding{{"sensor", f.sensor},
                           {"axes", axes_text(f.remedy)},
                           {"problem", f.problem},
                           {"remedy", f.text_of_remedy}};
    if (f.or_inverted) finding["or_axes"] = axes_text(-f.remedy);
    j["findings"].push_back(finding);
  }
  return j;
}

// What a good calibration needs and `info` cannot see; empty if there is nothing.
std::string open_question(const Survey& s) {
  for (const AxesFit& fit : s.mounting.fits) {
    if (fit.gyr_axes.empty()) {
      return "the sensors' directions do not turn as the gyroscope says, whatever the axes";
    }
  }
  if (s.turned.hardly_more) return "it turned about hardly more than one axis";
  if (s.hardly_turned()) {
    return fmt::format(
        "up pointed to {:.0f} % of all directions of the sensor only, so that its magnetometer's "
        "bias and the field look much alike; `magimu calibrate` tells how well it knows them",
        100.0 * s.coverage.up);
  }
  // Axes that may be right are no objection; calibrate does not object to them either.
  return std::ranges::all_of(s.mounting.fits, &AxesFit::may_be_straight)
             ? ""
             : "this motion does not tell which axes of the sensors are the same";
}

}  // namespace

std::string survey_verdict(const Survey& s) {
  const bool mag_turned = !s.mounting.findings.empty();
  if (!s.not_looked_further.empty()) {
    return "This recording cannot be calibrated as it is: " + s.not_looked_further;
  }
  if (!s.undetermined.empty()) {
    return "This recording cannot be calibrated: its motion leaves parameters undetermined.";
  }
  if (!s.turned.enough) {
    return "This recording cannot be calibrated. " + turned_too_little(s.turned);
  }
  if (!s.usable()) return "This recording cannot be calibrated before its axes are put right.";
  if (const Issue* fault = s.worst_fault()) {
    return "Do not expect a good calibration from it before this is mended: " + fault->text();
  }
  if (s.disturbed()) {
    return "Do not expect a good calibration from it: the field was disturbed.";
  }
  if (const std::string question = open_question(s); !question.empty()) {
    return "Whether a calibration from it will be good is open: " + question + ".";
  }
  if (s.mounting.status == MountingStatus::kUndecided) {
    return "It can be calibrated if the sensors' axes agree, which this motion does not tell.";
  }
  if (!s.coverage.missing.empty()) {
    return "It can be calibrated; with the motion that is missing the result would be better.";
  }
  return mag_turned ? "It can be calibrated; mind the magnetometer's axes."
                    : "It can be calibrated.";
}

std::string survey_text(const Survey& s) {
  std::string out = fmt::format("{}: {:.1f} s\n\n", s.recording, s.duration_s);
  if (!s.sensors.empty()) out += sensors_text(s) + rests_text(s);
  if (s.not_looked_further.empty()) {
    out += motion_text(s);
    out += "Axes: " + check_axes(s.mounting, s.distortion, s.dip_rad, s.dip_sign).sentence + "\n";
    out += field_text(s) + expected_text(s);
    for (const std::string& m : s.coverage.missing) out += "Missing: " + m + "\n";
  }
  return out + issues_text(s) + "\n" + survey_verdict(s) + "\n";
}

nlohmann::json survey_json(const Survey& s, const std::vector<std::string>& notes) {
  using nlohmann::json;
  json j{{"format", "magimu-info/1"},  {"recording", s.recording}, {"begin_s", s.begin_s},
         {"duration_s", s.duration_s}, {"notes", notes},           {"sensors", json::array()},
         {"rests", json::array()},     {"issues", json::array()},  {"usable", s.usable()}};
  for (const SensorSurvey& x : s.sensors) {
    j["sensors"].push_back({{"name", x.name},
                            {"unit", unit_of(sensor_named(x.name))},
                            {"samples", x.samples},
                            {"rate_hz", x.rate_hz},
                            {"longest_interval_s", x.longest_interval_s},
                            {"largest", x.largest},
                            {"noise_density", x.noise_density}});
  }
  for (const TimeSpan& r : s.rests) j["rests"].push_back({r.begin_s, r.end_s});
  if (s.gyr_bias_at_rest)
    j["gyroscope_at_rest"] = json_numbers<nlohmann::json>(*s.gyr_bias_at_rest);
  for (const Issue& issue : s.issues) j["issues"].push_back(issue_json(issue));
  j["not_looked_further"] = s.not_looked_further;
  if (!s.not_looked_further.empty()) return j;
  j["axes"] = mounting_json(s.mounting);
  j["motion"] = {{"turned_rad", json_numbers<nlohmann::json>(s.coverage.turned_rad)},
                 {"fastest_rad_s", s.coverage.fastest_rad_s},
                 {"up_coverage", s.coverage.up},
                 {"field_coverage", s.coverage.field},
                 {"missing", s.coverage.missing}};
  j["field"] = {{"dip_deg", s.dip_rad / kDegree},
                {"strength_uT", s.strength_uT},
                {"ellipsoid_rms_uT", s.ellipsoid_rms_uT}};
  j["expected"] = {{"motion", to_string(s.motion)}, {"undetermined", s.undetermined}};
  for (const ExpectedParameter& p : s.expected) j["expected"]["sigma"][p.name] = p.sigma;
  return j;
}

}  // namespace magimu::apps
