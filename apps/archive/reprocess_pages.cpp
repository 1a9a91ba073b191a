// SPDX-License-Identifier: BSD-3-Clause
#include "apps/archive/reprocess_pages.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "apps/page/report.h"
#include "apps/plot/plot.h"
#include "apps/say/numbers.h"
#include "archive/inventory/manifest.h"

namespace magimu::apps {
namespace {

constexpr int kDatesAtMost = 6, kNumbersAtMost = 12;  // labels on an axis of that width

std::string verdict_css(const std::string& verdict) {
  return verdict == "yes"       ? "answer predicts"
         : verdict == "limited" ? "answer limited"
                                : "answer unexplained";
}

std::string verdict_mark(const std::string& verdict) {
  const char* css = verdict == "yes"       ? "status ok"
                    : verdict == "limited" ? "status caution"
                                           : "status bad";
  return element("span", verdict.empty() ? "none" : verdict, css);
}

// The cells are HTML.
std::string html_table(const std::vector<std::string>& head,
                       const std::vector<std::vector<std::string>>& rows) {
  std::string top, body;
  for (const std::string& h : head) top += element("th", h, "t");
  for (const auto& row : rows) {
    std::string cells;
    for (const std::string& cell : row) cells += wrap("td", cell, "t");
    body += wrap("tr", cells);
  }
  return wrap("table", wrap("thead", wrap("tr", top)) + wrap("tbody", body));
}

std::string text_cell(const std::string& text) { return plot::escaped(text); }

struct HistoryPart {
  std::string title, unit;
  std::vector<std::string> names;  // in Device::order
  std::vector<std::string> labels;
};

struct HistoryAxis {
  std::string label;
  std::vector<double> x;  // of each recording
  std::vector<plot::Tick> ticks;
};

// Dates where all recordings have one and days tell them apart, else the recordings' numbers.
HistoryAxis history_axis(const Device& device) {
  HistoryAxis out;
  for (const std::size_t i : device.used) {
    const std::optional<double> day = days_of(device.recordings[i].date);
    if (day) out.x.push_back(*day);
  }
  const bool dated = out.x.size() == device.used.size();
  if (dated && out.x.back() - out.x.front() >= kDatesAtMost) {
    out.label = "date";
    for (const double day : plot::ticks({out.x.front(), out.x.back()}, kDatesAtMost)) {
      const std::chrono::sys_days date{std::chrono::days(std::lround(day))};
      out.ticks.push_back({day, fmt::format("{:%Y-%m-%d}", fmt::gmtime(date))});
    }
    return out;
  }
  out.label = "recording, in the order of time";
  out.x.clear();
  for (std::size_t k = 0; k < device.used.size(); ++k) out.x.push_back(double(k + 1));
  const std::size_t every = (out.x.size() - 1) / kNumbersAtMost + 1;
  for (std::size_t k = 0; k < out.x.size(); k += every) {
    out.ticks.push_back({out.x[k], std::to_string(k + 1)});
  }
  return out;
}

// Differences from the joint estimate at each recording, with two sigmas to both sides, and what
// each recording says by itself.
std::string history_picture(const Device& device, const HistoryPart& part) {
  constexpr plot::Colour kColours[] = {plot::Colour::kBlue, plot::Colour::kVermilion,
                                       plot::Colour::kGreen};
  plot::Chart chart;
  chart.title = part.title;
  const HistoryAxis axis = history_axis(device);
  chart.x_label = axis.label;
  chart.x_ticks = axis.ticks;
  chart.y_label = "change, " + part.unit;
  for (std::size_t i = 0; i < part.names.size(); ++i) {
    const auto at = std::ranges::find(device.order, part.names[i]);
    if (at == device.order.end()) return "";
    const auto column = Eigen::Index(at - device.order.begin());
    plot::Line line{.name = part.labels[i], .colour = kColours[i % 3], .width = 2.0};
    plot::Line own{.colour = kColours[i % 3], .width = 1.0, .dashed = true};
    plot::Band band{.colour = kColours[i % 3]};
    for (std::size_t k = 0; k < device.used.size(); ++k) {
      const double x = axis.x[k], y = device.at[k][column] - device.joint[column];
      const double s = 2.0 * device.sigma[k][column];
      line.x.push_back(x);
      line.y.push_back(y);
      band.x.push_back(x);
      band.low.push_back(y - s);
      band.high.push_back(y + s);
      const DeviceRecording& r = device.recordings[device.used[k]];
      const CondensedRecording& c = *r.condensed;
      const auto own_at = std::ranges::find(c.order, part.names[i]);
      const bool tells = own_at != c.order.end() && !r.at_device;
      own.x.push_back(x);
      own.y.push_back(tells ? c.at[own_at - c.order.begin()] - device.joint[column] : NAN);
    }
    chart.bands.push_back(band);
    chart.lines.push_back(own);
    chart.lines.push_back(line);
  }
  for (const FoundChange& f : device.history.changes) {
    if (f.change.kind != ChangeKind::kStep || !is_clear(f)) continue;
    chart.stretches.push_back({axis.x[f.change.at - 1], axis.x[f.change.at]});
    chart.stretches_name = "something changed";
  }
  return plot::svg(chart);
}

std::vector<HistoryPart> history_parts(const Device& device) {
  std::vector<HistoryPart> out;
  const auto vector_part = [&](const std::string& title, const std::string& prefix,
                               const std::string& unit) {
    HistoryPart part{title, unit, {}, {}};
    for (int i = 0; i < 3; ++i) {
      part.names.push_back(fmt::format("{}[{}]", prefix, i));
      part.labels.push_back(std::string(1, "xyz"[i]));
    }
    out.push_back(std::move(part));
  };
  const std::size_t magnetometers =
      device.calibration ? device.calibration->parameters.mag.size() : 0;
  for (std::size_t m = 0; m < std::min<std::size_t>(magnetometers, 4); ++m) {
    const std::string of =
        magnetometers > 1 ? " of " + device.calibration->mag_names[m] : std::string();
    const std::string prefix = fmt::format("magnetometers[{}]", m);
    vector_part("Hard iron o_m" + of, prefix + ".bias", "uT");
    HistoryPart diagonal{"Diagonal of the distortion D" + of, "uT", {}, {}};
    for (int i = 0; i < 3; ++i) {
      diagonal.names.push_back(fmt::format("{}.distortion[{}][{}]", prefix, i, i));
      diagonal.labels.push_back(fmt::format("D{0}{0}", i + 1));
    }
    out.push_back(std::move(diagonal));
  }
  vector_part("Gyroscope bias o_w", "gyroscope.bias", "rad/s");
  vector_part("Accelerometer bias o_a", "accelerometer.bias", "m/s²");
  return out;
}

}  // namespace

std::string fleet_page(const std::vector<FleetRecording>& rows,
                       const std::vector<FleetDevice>& devices,
                       const std::vector<std::string>& page_of, const std::string& devices_by) {
  Page page("Archive");
  std::size_t calibrated = 0, yes = 0, changed = 0;
  for (const FleetRecording& r : rows) calibrated += r.calibrated;
  for (const FleetDevice& d : devices) {
    yes += d.verdict == "yes";
    changed += std::ranges::any_of(d.changes, &FleetChange::clear);
  }
  page.html(wrap(
      "div",
      element("p", "magimu reprocess", "kicker") +
          element("h1", fmt::format("{} recordings of {} devices", rows.size(), devices.size())),
      "answer findings"));
  page.html(
      wrap("ul",
           fact(std::to_string(calibrated), "recordings with a calibration") +
               fact(std::to_string(rows.size() - calibrated), "without one, each with its reason") +
               fact(std::to_string(yes), "devices to rely on: two recordings agree") +
               fact(std::to_string(changed), "devices whose parameters change"),
           "facts"));
  page.section("Devices");
  if (!devices_by.empty()) page.paragraph(devices_by);
  std::vector<std::vector<std::string>> cells;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const FleetDevice& d = devices[i];
    std::string changes;
    for (const FleetChange& c : d.changes) changes += element("p", c.sentence);
    cells.push_back({"<a href=\"" + plot::escaped(page_of[i]) + "\">" + text_cell(d.name) + "</a>",
                     verdict_mark(d.verdict), fmt::format("{} of {}", d.used, d.recordings),
                     d.used > 0 ? text_cell(with_sigma(d.strength_uT, d.strength_sigma_uT)) : "",
                     text_cell(d.reason) + changes});
  }
  page.html(html_table(
      {"device", "verdict", "recordings used", "field, uT", "what there is to say"}, cells));
  page.section("Recordings without a calibration");
  cells.clear();
  for (const FleetRecording& r : rows) {
    if (r.calibrated) continue;
    cells.push_back({text_cell(r.path), text_cell(r.device), text_cell(r.status),
                     text_cell(r.reason), text_cell(r.remedy)});
  }
  if (cells.empty()) {
    page.paragraph("There is none.");
  } else {
    page.html(html_table({"recording", "device", "status", "why", "what to do"}, cells));
  }
  page.paragraph(
      "All numbers are in recordings.csv, devices.csv and changes.csv beside this page, and in "
      "archive.sqlite.",
      "soft");
  return page.finish();
}

std::string device_page(const Device& device, const FleetDevice& summary,
                        const std::vector<const FleetRecording*>& rows) {
  Page page("Device " + device.name);
  std::string head = element("p", "magimu reprocess: device " + device.name, "kicker");
  head += element("h1", summary.verdict == "yes"       ? "Its calibration can be used"
                        : summary.verdict == "limited" ? "Its calibration can be used within limits"
                                                       : "Do not use a calibration of this device");
  if (!summary.reason.empty()) head += element("p", summary.reason);
  page.html(wrap("div", head, verdict_css(summary.verdict)));
  page.section("What changed");
  if (summary.changes.empty()) {
    page.paragraph(device.used.size() < 2
                       ? "One recording tells nothing about changes."
                       : "Nothing that these recordings show: they are as probable with the same "
                         "parameters throughout.");
  }
  for (const FleetChange& c : summary.changes) page.paragraph(c.sentence);
  if (device.used.size() > 1) {
    for (const HistoryPart& part : history_parts(device)) {
      const std::string svg = history_picture(device, part);
      if (svg.empty()) continue;
      page.figure(svg,
                  "Relative to the estimate of all recordings together. Solid: at each recording, "
                  "given all of them, with two standard deviations; dashed: each recording by "
                  "itself, where it tells enough.");
    }
    page.paragraph(
        fmt::format("Recordings scatter about this by {:.2f} times their standard deviations; "
                    "where that is more than 1, the device's standard deviations include it.",
                    device.birge),
        "soft");
  }
  if (device.calibration) {
    page.section("Parameters");
    std::vector<std::vector<std::string>> cells;
    for (const FleetParameter& p : summary.parameters) {
      if (!p.recording.empty()) continue;
      const int n = decimals(p.sigma);
      cells.push_back(
          {p.name, fmt::format("{:.{}f}", p.value, n), fmt::format("{:.{}f}", p.sigma, n)});
    }
    page.table({"parameter", "value", "sigma"}, cells);
    page.paragraph(summary.changes.empty()
                       ? "Of all recordings together."
                       : "As they are at the last recording, given all of them and the changes.",
                   "soft");
  }
  page.section("Recordings");
  std::vector<std::vector<std::string>> cells;
  for (const FleetRecording* r : rows) {
    cells.push_back(
        {text_cell(r->path), text_cell(r->date), verdict_mark(r->verdict), r->used ? "yes" : "no",
         text_cell(r->agrees_with),
         r->calibrated && r->used ? fmt::format("{:.1f}", r->distance) : "",
         text_cell(r->reason) + (r->remedy.empty() ? "" : element("p", "To do: " + r->remedy))});
  }
  page.html(html_table(
      {"recording", "date", "verdict", "in the estimate", "agrees with", "distance, sigmas", "why"},
      cells));
  return page.finish();
}

}  // namespace magimu::apps
