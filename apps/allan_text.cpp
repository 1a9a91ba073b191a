// SPDX-License-Identifier: BSD-3-Clause
#include "apps/allan_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/report.h"
#include "apps/plot/plot.h"
#include "apps/say/numbers.h"
#include "graph/sensor.h"

namespace magimu::apps {
namespace {

std::string sensor_title(const std::string& name) {
  const std::string words = in_words(name);
  return words == name ? "magnetometer " + name : words;
}

// "0.00121 (0.00119 to 0.00123)", "at most 0.004".
std::string size(const Bounded& b) {
  if (!b.determined) return b.high > 0.0 ? fmt::format("at most {:.3g}", b.high) : "-";
  return fmt::format("{:.3g} ({:.3g} to {:.3g})", b.value, b.low, b.high);
}

// One number for the three axes: "0.0012", or "0.0012 to 0.0019" where they differ.
template <class Value>
std::string over_axes(const SensorNoise& s, const Value& value) {
  double low = INFINITY, high = 0.0;
  for (const AxisNoise& a : s.axes) {
    low = std::min(low, value(a));
    high = std::max(high, value(a));
  }
  return high < 1.05 * low ? fmt::format("{:.3g}", high)
                           : fmt::format("{:.3g} to {:.3g}", low, high);
}

int determined(const SensorNoise& s, Bounded AxisNoise::*member) {
  return int(std::count_if(s.axes.begin(), s.axes.end(),
                           [&](const AxisNoise& a) { return (a.*member).determined; }));
}

std::string in_degrees(const SensorNoise& s, double rad) {
  return s.name == "gyr" ? fmt::format(" ({:.3g} deg/s)", rad / kDegree) : "";
}

std::string white_sentence(const SensorNoise& s) {
  const double rate = 1.0 / s.interval_s;
  return fmt::format(
      "White noise of {} {} per sqrt(Hz){}: a single sample at {:.4g} Hz scatters by {:.3g} {}, "
      "the "
      "mean of a second by {:.3g}.",
      over_axes(s, [](const AxisNoise& a) { return a.white.value; }), s.unit,
      in_degrees(s, s.white()), rate, s.white() * std::sqrt(rate), s.unit, s.white());
}

std::string instability_sentence(const SensorNoise& s) {
  const auto lowest = std::min_element(
      s.axes.begin(), s.axes.end(),
      [](const auto& a, const auto& b) { return a.lowest.deviation < b.lowest.deviation; });
  if (std::all_of(s.axes.begin(), s.axes.end(), [](const auto& a) { return a.still_falling; })) {
    return fmt::format(
        "Bias instability: below {:.3g} {}; the Allan deviation still falls at {:.3g} s, so a "
        "longer rest would show more.",
        lowest->lowest.deviation / 0.664, s.unit, lowest->lowest.tau_s);
  }
  std::string text = fmt::format(
      "Bias instability {} {} (lowest Allan deviation / 0.664, at {} s): no averaging makes the "
      "bias better known than that",
      over_axes(s, [](const AxisNoise& a) { return a.lowest.deviation / 0.664; }), s.unit,
      over_axes(s, [](const AxisNoise& a) { return a.lowest.tau_s; }));
  if (determined(s, &AxisNoise::bias_instability) == 0) {
    return text + "; it is where white noise and random walk meet, flicker noise does not show.";
  }
  return text + ".";
}

std::string walk_sentence(const SensorNoise& s, double length_s) {
  const int count = determined(s, &AxisNoise::random_walk);
  if (count == 0) {
    return fmt::format(
        "Random walk of the bias: none shows within {:.0f} s; at most {} {} per sqrt(s), which "
        "is {:.3g} {} in an hour.",
        length_s, over_axes(s, [](const AxisNoise& a) { return a.random_walk.high; }), s.unit,
        60.0 * std::max({s.axes[0].random_walk.high, s.axes[1].random_walk.high,
                         s.axes[2].random_walk.high}),
        s.unit);
  }
  double largest = 0.0;
  for (const AxisNoise& a : s.axes) largest = std::max(largest, a.random_walk.value);
  return fmt::format(
      "Random walk of the bias, {} of 3 axes: up to {:.3g} {} per sqrt(s), which is {:.3g} {} "
      "in "
      "an hour.",
      count, largest, s.unit, 60.0 * largest, s.unit);
}

std::vector<std::vector<std::string>> rows(const SensorNoise& s) {
  std::vector<std::vector<std::string>> out;
  for (std::size_t i = 0; i < 3; ++i) {
    const AxisNoise& a = s.axes[i];
    out.push_back({s.name + " " + "xyz"[i], size(a.white), size(a.bias_instability),
                   size(a.random_walk),
                   fmt::format("{:.3g} at {:.3g} s", a.lowest.deviation, a.lowest.tau_s), s.unit});
  }
  return out;
}

const std::vector<std::string> kHead = {
    "axis", "white N, /sqrt(Hz)", "flicker B", "walk K, /sqrt(s)", "lowest Allan deviation",
    "unit"};

std::string allan_plot(const SensorNoise& s) {
  constexpr plot::Colour kColours[] = {plot::Colour::kBlue, plot::Colour::kVermilion,
                                       plot::Colour::kGreen};
  plot::Chart chart;
  chart.title = "Allan deviation of the " + sensor_title(s.name);
  chart.x_label = "averaging time tau, s";
  chart.y_label = s.unit;
  chart.log_x = chart.log_y = true;
  chart.width = 880.0;
  chart.height = 360.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const AxisNoise& a = s.axes[i];
    plot::Line measured{.name = std::string(1, "xyz"[i]), .colour = kColours[i], .width = 2.0};
    plot::Line fitted{.colour = plot::Colour::kGrey, .width = 1.0, .dashed = true};
    if (i == 2) fitted.name = "fitted";
    plot::Band band{.colour = kColours[i]};
    if (i == 2) band.name = "95 %";
    for (const AllanPoint& p : a.points) {
      measured.x.push_back(p.tau_s);
      measured.y.push_back(p.deviation);
      fitted.x.push_back(p.tau_s);
      fitted.y.push_back(model_deviation(a, p.tau_s));
      band.x.push_back(p.tau_s);
      band.low.push_back(p.low);
      band.high.push_back(p.high);
    }
    chart.bands.push_back(std::move(band));
    chart.lines.push_back(std::move(measured));
    chart.lines.push_back(std::move(fitted));
  }
  return plot::svg(chart);
}

}  // namespace

std::vector<std::string> noise_sentences(const SensorNoise& s) {
  if (!(s.white() > 0.0)) return {"Its noise cannot be told."};
  return {white_sentence(s), instability_sentence(s),
          walk_sentence(s, double(s.samples) * s.interval_s)};
}

std::string allan_table(const RestNoise& noise) {
  std::string out =
      fmt::format("{}: at rest from {:.1f} to {:.1f} s ({:.0f} s)\n\n", noise.recording,
                  noise.span.begin_s, noise.span.end_s, noise.span.length_s());
  out += fmt::format("{:<8}{:<36}{:<36}{:<36}{:<25}{}\n", kHead[0], kHead[1], kHead[2], kHead[3],
                     kHead[4], kHead[5]);
  for (const SensorNoise& s : noise.sensors) {
    for (const std::vector<std::string>& row : rows(s)) {
      out += fmt::format("{:<8}{:<36}{:<36}{:<36}{:<25}{}\n", row[0], row[1], row[2], row[3],
                         row[4], row[5]);
    }
  }
  out += "In brackets: 95 % confidence.\n";
  for (const SensorNoise& s : noise.sensors) {
    out += "\n" + sensor_title(s.name) + ":\n";
    for (const std::string& sentence : noise_sentences(s)) out += "  " + sentence + "\n";
  }
  for (const std::string& note : noise.notes) out += "\nNote: " + note + "\n";
  return out;
}

std::string allan_report(const RestNoise& noise) {
  Page page("Noise at rest of " + noise.recording);
  page.html(wrap("div",
                 element("p", "magimu allan: " + noise.recording, "kicker") +
                     element("h1", fmt::format("The noise of {} sensors, from {:.0f} s at rest",
                                               noise.sensors.size(), noise.span.length_s())) +
                     element("p",
                             "Densities of white noise, the floor that averaging reaches, and "
                             "how fast the biases walk away."),
                 "answer findings"));
  for (const SensorNoise& s : noise.sensors) {
    std::string title = sensor_title(s.name);
    title[0] = char(std::toupper((unsigned char)(title[0])));
    page.section(title);
    std::string items;
    for (const std::string& sentence : noise_sentences(s)) items += element("li", sentence);
    page.html(wrap("ul", items));
    page.figure(allan_plot(s),
                "Scatter of neighbouring means over tau seconds, divided by sqrt(2). White noise "
                "falls as 1 / sqrt(tau); the floor is bias instability; what rises is random walk. "
                "Shaded: 95 % confidence; dashed: the fitted densities.");
    page.table(kHead, rows(s));
  }
  if (!noise.notes.empty()) {
    page.section("Notes");
    std::string items;
    for (const std::string& note : noise.notes) items += element("li", note);
    page.html(wrap("ul", items));
  }
  page.section("How this was computed");
  page.paragraph(
      "Overlapping Allan deviation with confidence from its equivalent degrees of freedom; N, B "
      "and "
      "K by maximum likelihood from the differences of block means of 0.05 s, and only "
      "what is worth its parameter (1 %).",
      "soft");
  return page.finish();
}

}  // namespace magimu::apps
