// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/report_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <sstream>

#include "apps/page/report.h"
#include "apps/page/report_field_gain.h"
#include "apps/page/report_pictures.h"
#include "apps/page/residual_pictures.h"
#include "apps/plot/plot.h"
#include "apps/say/numbers.h"
#include "apps/say/parameter_words.h"
#include "calibration/use/apply.h"
#include "recording/checks/gate.h"

namespace magimu::apps {
namespace {

std::string names(const Calibration& c) {
  std::string out;
  for (const TrajectoryEstimate& t : c.trajectories) out += (out.empty() ? "" : ", ") + t.recording;
  return out;
}

const Check* find_check(const Calibration& c, const std::string& name) {
  const auto it = std::find_if(c.checks.begin(), c.checks.end(),
                               [&](const Check& check) { return check.name == name; });
  return it == c.checks.end() ? nullptr : &*it;
}

void answer(Page& page, const Calibration& c) {
  struct Look {
    const char *headline, *css;
  };
  constexpr Look kLooks[] = {{"This calibration can be used", "answer predicts"},
                             {"This calibration can be used within limits", "answer limited"},
                             {"Do not use this calibration", "answer unexplained"}};
  const Look look = kLooks[int(c.trust.verdict)];
  std::string html = element("p", "magimu calibrate: " + names(c), "kicker");
  html += element("h1", look.headline);
  if (!c.trust.reasons.empty()) html += wrap("ul", items(c.trust.reasons));
  const auto cautions = std::count_if(c.checks.begin(), c.checks.end(), [](const Check& check) {
    return check.status != CheckStatus::kOk;
  });
  if (c.trust.verdict == Verdict::kYes && c.trust.reasons.empty()) {
    std::string text = "The fit has converged and everything is determined";
    text += cautions == 0 ? ", and what it leaves looks like noise."
                          : fmt::format(
                                ". {} of {} checks call for caution (below); the standard "
                                "deviations take them into account.",
                                cautions, c.checks.size());
    html += element("p", text);
  }
  page.html(wrap("div", html, look.css));
  double duration = 0.0;
  for (const TrajectoryEstimate& t : c.trajectories) {
    if (!t.t.empty()) duration += t.t.back() - t.t.front();
  }
  const Check* accuracy = find_check(c, "accuracy");
  std::string facts =
      fact(fmt::format("{:.0f} s", duration), fmt::format("recorded, {} IMU samples", c.samples));
  if (accuracy != nullptr) {
    facts += fact(fmt::format("{:.2g}°", accuracy->value),
                  "standard deviation of the corrected field's direction, at worst");
  }
  facts += fact(fmt::format("{} uT", with_sigma(c.strength_uT, c.strength_sigma_uT)),
                "strength of the field");
  facts += fact(fmt::format("{}°", with_sigma(c.fields.front().dip_rad / kDegree,
                                              c.fields.front().dip_sigma_rad / kDegree)),
                "dip, downward");
  facts += fact(moved_how(c.motion), "motion, as modelled");
  page.html(wrap("ul", facts, "facts"));
  if (!c.warnings.empty()) page.html(wrap("ul", items(c.warnings), "soft"));
}

// Per cent with two digits.
std::string percent_of(double share) { return fmt::format("{:.2g}", 100.0 * share); }
std::string degrees_of(double deg) {
  return fmt::format("{:.{}f}", deg, deg < 0.1 ? 3 : deg < 1.0 ? 2 : deg < 10.0 ? 1 : 0);
}

void field(Page& page, const Calibration& c, const std::vector<const Recording*>& recordings,
           std::size_t m) {
  const std::string which = c.mag_names.size() > 1 ? " of " + c.mag_names[m] : "";
  page.section("The field before and after" + which);
  std::string row;
  for (const std::string& svg : sphere_pictures(c, recordings, m)) row += wrap("figure", svg);
  const FieldGain gain = field_gain(c, recordings, m);
  std::string facts;
  if (std::isfinite(gain.length_before)) {
    facts += fact(
        fmt::format("{} → {} %", percent_of(gain.length_before), percent_of(gain.length_after)),
        "scatter of the field's length (RMS, of the length)");
  }
  if (std::isfinite(gain.heading_before_deg)) {
    facts += fact(fmt::format("{} → {}°", degrees_of(gain.heading_before_deg),
                              degrees_of(gain.heading_after_deg)),
                  "heading error, against the estimated motion (RMS)");
  }
  if (!facts.empty()) page.html(wrap("ul", facts, "facts"));
  page.html(wrap("div", row, "triple"));
  page.paragraph(
      "Each dot is a reading, seen along the third axis. Turned about in one field, corrected "
      "readings lie on a sphere (grey: its outline) about the origin.",
      "soft");
  page.figure(length_picture(c, recordings, m),
              "Whatever the sensor's attitude, a corrected reading has the length of the field.");
}

void residuals(Page& page, const Calibration& c, const ResidualSeries& series) {
  if (series.t.empty()) return;
  const bool acc = series.sensor == "acc", gyr = series.sensor == "gyr";
  const std::string name = acc                      ? "accelerometer"
                           : gyr                    ? "gyroscope"
                           : c.mag_names.size() > 1 ? series.sensor
                                                    : "magnetometer";
  page.section("What the model leaves of the " + name);
  const Sensor channel = sensor_named(series.sensor);
  const ResidualPictures pictures =
      residual_pictures({channel, series.t, series.whitened, {}}, false);
  const std::string text =
      "Measured less predicted, in standard deviations of the noise that was assumed. ";
  if (gyr || (acc && is_moved(c.motion))) {
    page.figure(pictures.traces,
                text +
                    "The estimated trajectory follows this sensor, so little is left of its "
                    "noise: what stands out here contradicts the other sensors.");
    return;
  }
  page.figure(pictures.traces, text +
                                   "With the right model it stays within the grey band for 99 % "
                                   "of the time.");
  page.html("<div class=\"pair\">\n");
  page.figure(pictures.correlation, "Noise forgets at once: all of it in the grey band.");
  page.figure(pictures.spectrum, "Noise is flat. Low frequencies: drifts; peaks: vibration.");
  page.html("</div>\n");
}

void all_residuals(Page& page, const Calibration& c) {
  constexpr const char* kNames[] = {"accelerometer", "gyroscope", "magnetometer"};
  constexpr const char* kUnits[] = {"m/s^2", "rad/s", "uT"};
  const double densities[] = {c.noise.acc, c.noise.gyr, c.noise.mag};
  std::vector<std::vector<std::string>> rows;
  for (std::size_t s = 0; s < 3; ++s) {
    rows.push_back({kNames[s], fmt::format("{:.3g} {} per sqrt(Hz)", densities[s], kUnits[s]),
                    fmt::format("{:.2f}", c.residuals[s].rms), plain(c.residuals[s].rms_unit),
                    kUnits[s]});
  }
  page.table({"sensor", std::string("noise, ") + (c.noise_given ? "given" : "estimated"),
              "residual (1: noise alone)", "per node", "unit"},
             rows);
}

double value_of(const Calibration& c, const std::string& name) {
  const auto digits = [&](std::size_t which) {
    std::size_t at = 0, seen = 0;
    for (; at < name.size(); ++at) {
      if (name[at] == '[' && seen++ == which) return std::size_t(std::stoul(name.substr(at + 1)));
    }
    return std::size_t(0);
  };
  if (name.starts_with("accelerometer.bias")) return c.parameters.acc_bias[Eigen::Index(digits(0))];
  if (name.starts_with("gyroscope.bias")) return c.parameters.gyr_bias[Eigen::Index(digits(0))];
  if (name.find(".distortion[") != std::string::npos) {
    return c.parameters.mag[digits(0)].distortion(Eigen::Index(digits(1)), Eigen::Index(digits(2)));
  }
  if (name.starts_with("magnetometers") && name.find("].bias[") != std::string::npos) {
    return c.parameters.mag[digits(0)].bias[Eigen::Index(digits(1))];
  }
  if (name == "field.dip_deg") return c.fields.front().dip_rad / kDegree;
  if (name.starts_with("fields[")) return c.fields[digits(0)].dip_rad / kDegree;
  for (const ActiveEffect& effect : c.effects) {
    for (const ActiveEffect::Parameter& p : effect.parameters) {
      if (p.name == name) return p.value;
    }
  }
  return NAN;
}

void parameters(Page& page, const Calibration& c) {
  page.section("Parameters");
  std::vector<std::vector<std::string>> rows;
  for (const std::string& name : c.order) {
    const double robust = c.sigma(name), model = c.sigma_model(name), value = value_of(c, name);
    const int n = decimals(robust);
    rows.push_back({calibration_parameter_words(name, c.mag_names),
                    fmt::format("{:.{}f}", value, n), fmt::format("{:.{}f}", robust, n),
                    fmt::format("{:.2g}", model),
                    model > 0.0 ? fmt::format("{:.1f}", robust / model) : "-",
                    calibration_parameter_unit(name)});
  }
  page.table({"parameter", "value", "sigma", "sigma of the model", "ratio", "unit"}, rows);
  page.paragraph(
      "sigma: from the scatter of the fit over blocks of seconds, right also where residuals are "
      "not white: the one to use. sigma of the model: what white noise of the densities above "
      "would "
      "give. A ratio far above 1 says how much more the real sensors err than their noise.",
      "soft");
  if (!c.undetermined.empty()) {
    page.paragraph("Undetermined by this motion:");
    page.html(wrap("ul", items(c.undetermined)));
  }
}

void coverage_section(Page& page, const Calibration& c) {
  page.section("Coverage of directions");
  page.html("<div class=\"pair\">\n");
  page.figure(
      coverage_picture(c, false),
      fmt::format("The field came from {:.0f} % of all directions.", 100.0 * coverage(c, false)));
  page.figure(coverage_picture(c, true),
              fmt::format("Up lay in {:.0f} % of all directions.", 100.0 * coverage(c, true)));
  page.html("</div>\n");
  page.paragraph(
      "The sphere of directions as a map of equal areas. Empty regions are attitudes in which the "
      "sensor was never held; there the calibration is less certain.",
      "soft");
}

void checks(Page& page, const Calibration& c) {
  page.section("Checks");
  std::string body;
  for (const Check& check : c.checks) {
    body +=
        wrap("tr",
             element("td", check.name, "t") +
                 wrap("td",
                      element("span", to_string(check.status), "status " + to_string(check.status)),
                      "t") +
                 element("td", check.sentence, "t"));
  }
  page.html(scrolling_table(wrap("tr", element("th", "check", "t") + element("th", "status", "t") +
                                           element("th", "what it says", "t")),
                            body));
}

void use(Page& page, const Calibration& c, const std::vector<const Recording*>& recordings) {
  page.section("How to use it");
  const Applied applied = apply(c, slice(*recordings.front(), 0.0, 0.0));
  for (const std::string& formula : applied.formulas) {
    std::string lines;
    std::istringstream text(formula);
    for (std::string line; std::getline(text, line);) lines += plot::escaped(line) + "\n";
    page.html(wrap("pre", lines));
  }
  page.paragraph(
      "magimu apply corrects a recording so; magimu export writes these numbers for PX4, "
      "ArduPilot, ROS, MATLAB and C.",
      "soft");
}

}  // namespace

std::string calibration_report(const Calibration& c, const std::vector<const Recording*>& given) {
  // Without the readings that were set aside, which would set the scale of every picture.
  std::deque<Recording> kept;
  std::vector<const Recording*> recordings;
  for (const Recording* r : given) {
    kept.push_back(gated(*r).value_or(*r));
    recordings.push_back(&kept.back());
  }
  Page page("Calibration of " + names(c));
  answer(page, c);
  for (std::size_t m = 0; m < c.mag_names.size(); ++m) field(page, c, recordings, m);
  checks(page, c);
  parameters(page, c);
  coverage_section(page, c);
  // Magnetometers first: they show most.
  for (std::size_t s = 2; s < c.residual_series.size(); ++s) {
    residuals(page, c, c.residual_series[s]);
  }
  for (std::size_t s = 0; s < std::min<std::size_t>(2, c.residual_series.size()); ++s) {
    residuals(page, c, c.residual_series[s]);
  }
  page.section("Residuals and noise of all sensors");
  all_residuals(page, c);
  page.section("Convergence");
  page.figure(
      convergence_picture(c),
      fmt::format("{} iterations with all {} nodes ({}); the start came from a fit with few "
                  "nodes. {:.1f} s in all.",
                  c.fit.iterations, c.nodes, to_string(c.fit.reason), c.seconds));
  if (c.trust.verdict != Verdict::kNo) use(page, c, recordings);
  return page.finish();
}

}  // namespace magimu::apps
