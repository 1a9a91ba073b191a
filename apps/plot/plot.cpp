// SPDX-License-Identifier: BSD-3-Clause
#include "apps/plot/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/plot/plot_frame.h"

namespace magimu::plot {
namespace {

std::string curve(const Line& line, const Axis& x, const Axis& y) {
  std::string d;
  bool down = false;  // the pen
  for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i) {
    if (!x.shows(line.x[i]) || !y.shows(line.y[i])) {
      down = false;
      continue;
    }
    // A point without neighbours still shows: a line of no length with a round end.
    d += fmt::format("{}{:.1f} {:.1f}", down ? "L" : "M", x(line.x[i]), y(line.y[i]));
    if (!down) d += "h0";
    down = true;
  }
  return fmt::format(R"(<path d="{}" fill="none" stroke="{}" stroke-width="{}")"
                     R"( stroke-linejoin="round" stroke-linecap="round"{}/>)"
                     "\n",
                     d, hex(line.colour), line.width,
                     line.dashed ? R"( stroke-dasharray="6 4")" : "");
}

std::string area(const Band& band, const Axis& x, const Axis& y) {
  std::string out, there, back;
  const auto close = [&] {
    if (!there.empty()) {
      out += fmt::format(R"(<path d="M{}{}Z" fill="{}" fill-opacity="0.25"/>)"
                         "\n",
                         there.substr(1), back, hex(band.colour));
    }
    there.clear();
    back.clear();
  };
  for (std::size_t i = 0; i < std::min({band.x.size(), band.low.size(), band.high.size()}); ++i) {
    if (x.shows(band.x[i]) && y.shows(band.low[i]) && y.shows(band.high[i])) {
      there += fmt::format("L{:.1f} {:.1f}", x(band.x[i]), y(band.high[i]));
      back.insert(0, fmt::format("L{:.1f} {:.1f}", x(band.x[i]), y(band.low[i])));
    } else {
      close();
    }
  }
  close();
  return out;
}

}  // namespace

std::string svg(const Chart& chart) {
  std::vector<LegendEntry> legend;
  Extent x_extent(chart.log_x), y_extent(chart.log_y);
  for (const Line& line : chart.lines) {
    if (!line.name.empty()) legend.push_back({line.name, line.colour, false, line.dashed});
    x_extent.add(line.x);
    y_extent.add(line.y);
  }
  for (const Band& band : chart.bands) {
    if (!band.name.empty()) legend.push_back({band.name, band.colour, true, false});
    x_extent.add(band.x);
    y_extent.add(band.low);
    y_extent.add(band.high);
  }
  if (!chart.stretches.empty() && !chart.stretches_name.empty()) {
    legend.push_back({chart.stretches_name, Colour::kOrange, true, false});
  }
  Frame frame(chart.title, chart.width, chart.height, legend);
  const Axis x{chart.x_range.value_or(x_extent.range(0.0)), chart.log_x, frame.left(),
               frame.right()};
  const Axis y{chart.y_range.value_or(y_extent.range(0.05)), chart.log_y, frame.bottom(),
               frame.top()};
  frame.x_axis(x, chart.x_label, chart.x_ticks);
  frame.y_axis(y, chart.y_label);
  for (const Range& s : chart.stretches) {
    const double width = std::max(1.0, x(s.high) - x(s.low));  // a short one shows, too
    frame.add(fmt::format(
        R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}" fill-opacity="0.25"/>)"
        "\n",
        std::min(x(s.low), frame.right() - width), frame.top(), width, frame.bottom() - frame.top(),
        hex(Colour::kOrange)));
  }
  for (const Band& band : chart.bands) frame.add(area(band, x, y));
  for (const Line& line : chart.lines) frame.add(curve(line, x, y));
  return frame.finish();
}

std::string svg(const BarChart& chart) {
  std::vector<LegendEntry> legend;
  double highest = 0.0;
  for (const Bars& bars : chart.bars) {
    if (!bars.name.empty()) legend.push_back({bars.name, bars.colour, false, false});
    for (const double v : bars.values) highest = std::isfinite(v) ? std::max(highest, v) : highest;
  }
  Frame frame(chart.title, chart.width, chart.height, legend);
  const double top = chart.cut && *chart.cut < highest ? *chart.cut : highest;
  const Axis y{{0.0, top > 0.0 ? 1.08 * top : 1.0}, false, frame.bottom(), frame.top()};
  frame.y_axis(y, chart.y_label);
  const double group =
      (frame.right() - frame.left()) / double(std::max<std::size_t>(1, chart.groups.size()));
  const double bar = 0.84 * group / double(std::max<std::size_t>(1, chart.bars.size()));
  for (std::size_t g = 0; g < chart.groups.size(); ++g) {
    const double begin = frame.left() + group * (double(g) + 0.08);
    for (std::size_t b = 0; b < chart.bars.size(); ++b) {
      const Bars& bars = chart.bars[b];
      if (g >= bars.values.size() || !std::isfinite(bars.values[g])) continue;
      const double value = bars.values[g], x = begin + bar * double(b);
      const double high = y(std::min(value, top));
      frame.add(rectangle(x + 1.0, high, bar - 2.0, frame.bottom() - high, hex(bars.colour)));
      if (value > top) frame.add(rectangle(x, high + 10.0, bar, 3.0, "#fff"));
      frame.add(text(x + 0.5 * bar, high - 4.0, fmt::format("{:.{}f}", value, value < 9.95 ? 1 : 0),
                     "middle", 10));
    }
    std::string_view rest = chart.groups[g];
    for (double line = frame.bottom() + 16.0; !rest.empty(); line += 14.0) {
      const auto end = std::min(rest.find('\n'), rest.size());
      frame.add(text(begin + 0.42 * group, line, rest.substr(0, end), "middle"));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  return frame.finish();
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += (unsigned char)(c) < 0x20 ? ' ' : c;  // XML has no control characters
    }
  }
  return out;
}

}  // namespace magimu::plot
