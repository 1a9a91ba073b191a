// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/report_survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "apps/page/report.h"
#include "apps/plot/plot.h"
#include "apps/say/numbers.h"
#include "apps/say/parameter_words.h"
#include "graph/sensor.h"
#include "recording/checks/gate.h"

namespace magimu::apps {
namespace {

constexpr std::size_t kDots = 900;    // of a cloud: twice as many at most
constexpr std::size_t kOnLine = 900;  // of a line over time, likewise

struct Series {
  std::string name, unit;
  const VectorSeries* samples;
};

std::vector<Series> sensors_of(const Recording& r) {
  std::vector<Series> out{{"accelerometer", "m/s²", &r.acc}, {"gyroscope", "rad/s", &r.gyr}};
  for (std::size_t m = 0; m < r.mag.size(); ++m) {
    out.push_back({r.mag.size() == 1 ? "magnetometer" : r.mag_names[m], "uT", &r.mag[m]});
  }
  return out;
}

std::string capital(std::string text) {
  if (!text.empty()) text.front() = char(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

void answer(Page& page, const SurveyedRecording& of) {
  const Survey& s = of.survey;
  const bool doubts = s.worst_fault() != nullptr || !s.coverage.missing.empty();
  const char* look = !s.usable() ? "answer unexplained"
                     : doubts    ? "answer limited"
                                 : "answer predicts";
  std::string html = element("p", "magimu info: " + s.recording, "kicker");
  html += element("h1", of.verdict);
  if (!s.coverage.missing.empty()) html += wrap("ul", items(s.coverage.missing));
  page.html(wrap("div", html, look));
  std::string facts = fact(fmt::format("{:.0f} s", s.duration_s), "recorded");
  double rest = 0.0;
  for (const TimeSpan& r : s.rests) rest += r.end_s - r.begin_s;
  facts += fact(fmt::format("{:.0f} s", rest), fmt::format("at rest, {} times", s.rests.size()));
  if (s.not_looked_further.empty()) {
    facts += fact(fmt::format("{:.0f} %", 100.0 * s.coverage.field),
                  "of all directions: where the field came from");
    facts +=
        fact(fmt::format("{:.0f} %", 100.0 * s.coverage.up), "of all directions: where up was");
    facts += fact(fmt::format("{:.3g} uT", s.strength_uT), "field, roughly");
    facts += fact(fmt::format("{:.0f}°", s.dip_rad / kDegree), "dip, downward, roughly");
  }
  page.html(wrap("ul", facts, "facts"));
}

void issues(Page& page, const Survey& s) {
  page.section("What is wrong with the samples");
  if (s.issues.empty()) {
    page.paragraph("Nothing was found.");
    return;
  }
  std::string body;
  for (const Issue& issue : s.issues) {
    const char* css = issue.severity == Severity::kFatal     ? "status bad"
                      : issue.severity == Severity::kCaution ? "status caution"
                                                             : "status";
    body += wrap("tr", wrap("td", element("span", to_string(issue.severity), css), "t") +
                           element("td", capital(issue.problem) + ".", "t") +
                           element("td", capital(issue.remedy) + ".", "t"));
  }
  page.html(scrolling_table(wrap("tr", element("th", "", "t") + element("th", "problem", "t") +
                                           element("th", "remedy", "t")),
                            body));
}

void sensors(Page& page, const Survey& s) {
  page.section("Sensors");
  std::vector<std::vector<std::string>> rows;
  for (const SensorSurvey& x : s.sensors) {
    const char* unit = x.name == "acc" ? "m/s²" : x.name == "gyr" ? "rad/s" : "uT";
    rows.push_back({in_words(x.name), fmt::format("{}", x.samples),
                    fmt::format("{:.4g} Hz", x.rate_hz),
                    fmt::format("{:.1f} ms", 1e3 * x.longest_interval_s),
                    fmt::format("{:.4g} {}", x.largest, unit),
                    x.noise_density > 0.0 ? fmt::format("{:.3g} {}/√Hz", x.noise_density, unit)
                                          : std::string("-")});
  }
  page.table({"sensor", "samples", "rate", "longest gap", "largest reading", "noise at rest"},
             rows);
}

// One axis over the recording's own time, thinned to every n-th sample.
plot::Line line_of(const VectorSeries& series, int axis) {
  constexpr plot::Colour kColours[] = {plot::Colour::kVermilion, plot::Colour::kGreen,
                                       plot::Colour::kBlue};
  plot::Line out{.name = std::string(1, "xyz"[axis]), .colour = kColours[axis], .width = 1.0};
  const std::size_t every = std::max<std::size_t>(1, series.size() / kOnLine);
  for (std::size_t k = 0; k < series.size(); k += every) {
    out.x.push_back(series.t[k]);
    out.y.push_back(series.v[k][axis]);
  }
  return out;
}

void readings(Page& page, const Survey& s, const Recording& recording) {
  page.section("The readings");
  for (const Series& sensor : sensors_of(recording)) {
    if (sensor.samples->empty()) continue;
    plot::Chart chart;
    chart.title = capital(sensor.name);
    chart.x_label = "time, s";
    chart.y_label = sensor.unit;
    chart.width = 880.0;
    chart.height = 210.0;
    for (int axis = 0; axis < 3; ++axis) chart.lines.push_back(line_of(*sensor.samples, axis));
    for (const TimeSpan& r : s.rests) chart.stretches.push_back({r.begin_s, r.end_s});
    if (!s.rests.empty()) chart.stretches_name = "at rest";
    page.figure(plot::svg(chart), "");
  }
}

// One magnetometer as it reads, seen along the three axes.
void spheres(Page& page, const VectorSeries& mag, const std::string& name) {
  if (mag.empty()) return;
  page.section("The field as the " + name + " reads it");
  double limit = 1.0;
  for (const Vector3& v : mag.v) limit = std::max(limit, 1.05 * v.cwiseAbs().maxCoeff());
  const std::size_t every = std::max<std::size_t>(1, mag.size() / kDots);
  std::string row;
  for (const auto& [x, y] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    plot::Chart chart;
    chart.title = fmt::format("{} and {}, uT", "xyz"[x], "xyz"[y]);
    chart.x_label = std::string(1, "xyz"[x]);
    chart.y_label = std::string(1, "xyz"[y]);
    chart.width = 300.0;
    chart.height = 318.0;
    chart.x_range = chart.y_range = plot::Range{-limit, limit};
    plot::Line dots{.name = "", .colour = plot::Colour::kVermilion, .width = 2.6};
    for (std::size_t k = 0; k < mag.size(); k += every) {
      dots.x.insert(dots.x.end(), {mag.v[k][x], NAN});
      dots.y.insert(dots.y.end(), {mag.v[k][y], NAN});
    }
    chart.lines.push_back(std::move(dots));
    row += wrap("figure", plot::svg(chart));
  }
  page.html(wrap("div", row, "triple"));
  page.paragraph(
      "Each dot is a reading, seen along the third axis. All attitudes together make an ellipsoid; "
      "where dots are missing the sensor was never held, and stray dots are disturbances.",
      "soft");
}

void expected(Page& page, const Survey& s, const std::vector<std::string>& mag_names) {
  page.section("How well a calibration would know its parameters");
  if (!s.undetermined.empty()) {
    page.paragraph("This motion leaves free:");
    page.html(wrap("ul", items(s.undetermined)));
  }
  std::vector<std::vector<std::string>> rows;
  for (const ExpectedParameter& p : s.expected) {
    const char* unit = p.name.starts_with("accelerometer")           ? "m/s²"
                       : p.name.starts_with("gyroscope")             ? "rad/s"
                       : p.name.find("dip_deg") != std::string::npos ? "deg"
                                                                     : "uT";
    rows.push_back(
        {calibration_parameter_words(p.name, mag_names), fmt::format("{:.2g}", p.sigma), unit});
  }
  page.table({"parameter", "standard deviation", "unit"}, rows);
}

}  // namespace

std::string survey_page(const std::vector<SurveyedRecording>& all) {
  std::string names;
  for (const SurveyedRecording& one : all) {
    names += (names.empty() ? "" : ", ") + one.survey.recording;
  }
  Page page("What is in " + names);
  for (const SurveyedRecording& one : all) {
    // Readings that no measurement can have given would set the scale of every picture.
    const Recording kept = gated(*one.recording).value_or(*one.recording);
    answer(page, one);
    issues(page, one.survey);
    if (!one.survey.sensors.empty()) sensors(page, one.survey);
    for (std::size_t m = 0; m < kept.mag.size(); ++m) {
      spheres(page, kept.mag[m], kept.mag.size() == 1 ? "magnetometer" : kept.mag_names[m]);
    }
    readings(page, one.survey, kept);
    if (one.survey.not_looked_further.empty()) expected(page, one.survey, kept.mag_names);
  }
  return page.finish();
}

}  // namespace magimu::apps
