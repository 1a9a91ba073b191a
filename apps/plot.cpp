// SPDX-License-Identifier: BSD-3-Clause
#include "apps/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace magimu::plot {
namespace {

constexpr double kLeft = 62.0, kRight = 16.0, kBottom = 46.0;  // margins
constexpr double kTitle = 28.0, kLegendRow = 18.0;
constexpr double kCharacter = 6.4;  // mean width at 12 pixels, for the legend
constexpr int kTicks = 8, kTicksX = 10;

const char* hex(Colour colour) {
  constexpr const char* kHex[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                  "#56B4E9", "#E69F00", "#767676"};
  return kHex[int(colour)];
}

std::string text(double x, double y, std::string_view content, const char* anchor, int size = 12,
                 const char* more = "") {
  return fmt::format(R"(<text x="{:.1f}" y="{:.1f}" font-size="{}" text-anchor="{}"{}>{}</text>)"
                     "\n",
                     x, y, size, anchor, more, escaped(content));
}

std::string segment(double x1, double y1, double x2, double y2, const char* colour) {
  return fmt::format(R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke="{}"/>)"
                     "\n",
                     x1, y1, x2, y2, colour);
}

std::string rectangle(double x, double y, double width, double height, const std::string& fill) {
  return fmt::format(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}"/>)"
                     "\n",
                     x, y, width, height, fill);
}

struct LegendEntry {
  std::string name;
  Colour colour;
  bool area, dashed;
};

// What both kinds of picture have around their content.
class Page {
 public:
  Page(const std::string& title, double width, double height,
       const std::vector<LegendEntry>& legend)
      : width_(width), height_(height) {
    out_ = fmt::format(
        R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0:.0f} {1:.0f}" width="{0:.0f}" )"
        R"(height="{1:.0f}" font-family="Helvetica, Arial, sans-serif" fill="#333">)"
        "\n",
        width, height);
    out_ += rectangle(0.0, 0.0, width, height, "#fff");
    out_ += text(kLeft, 19.0, title, "start", 14, R"( font-weight="bold")");
    double x = kLeft, y = kTitle + 12.0;
    for (const LegendEntry& entry : legend) {
      const double wide = 34.0 + kCharacter * double(entry.name.size()) + 16.0;
      if (x > kLeft && x + wide > width - kRight) {
        x = kLeft;
        y += kLegendRow;
      }
      out_ += fmt::format(
          R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke="{}" stroke-width="{}"{}/>)"
          "\n",
          x, y - 4.0, x + 24.0, y - 4.0, hex(entry.colour), entry.area ? 11 : 3,
          entry.area     ? R"( stroke-opacity="0.25")"
          : entry.dashed ? R"( stroke-dasharray="6 4")"
                         : "");
      out_ += text(x + 30.0, y, entry.name, "start");
      x += wide;
    }
    top_ = (legend.empty() ? kTitle : y) + 10.0;
  }

  double top() const { return top_; }
  double left() const { return kLeft; }
  double right() const { return width_ - kRight; }
  double bottom() const { return height_ - kBottom; }
  void add(const std::string& svg) { out_ += svg; }

  void y_axis(const Axis& y, const std::string& label) {
    for (const double v : y.log ? log_ticks(y.range) : ticks(y.range, kTicks)) {
      add(segment(left(), y(v), right(), y(v), "#e4e4e4"));
      add(text(left() - 6.0, y(v) + 4.0, fmt::format("{:g}", v), "end"));
    }
    const double middle = 0.5 * (top() + bottom());
    add(text(14.0, middle, label, "middle", 12,
             fmt::format(R"~( transform="rotate(-90 14 {:.1f})")~", middle).c_str()));
  }
  void x_axis(const Axis& x, const std::string& label) {
    for (const double v : ticks(x.range, kTicksX)) {
      add(segment(x(v), top(), x(v), bottom(), "#e4e4e4"));
      add(text(x(v), bottom() + 16.0, fmt::format("{:g}", v), "middle"));
    }
    add(text(0.5 * (left() + right()), height_ - 10.0, label, "middle"));
  }
  std::string finish() {
    return out_ + segment(left(), top(), left(), bottom(), "#444") +
           segment(left(), bottom(), right(), bottom(), "#444") + "</svg>\n";
  }

 private:
  double width_, height_, top_;
  std::string out_;
};

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
  Extent x_extent, y_extent(chart.log_y);
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
  Page page(chart.title, chart.width, chart.height, legend);
  const Axis x{chart.x_range.value_or(x_extent.range(0.0)), false, page.left(), page.right()};
  const Axis y{chart.y_range.value_or(y_extent.range(0.05)), chart.log_y, page.bottom(),
               page.top()};
  page.x_axis(x, chart.x_label);
  page.y_axis(y, chart.y_label);
  for (const Range& s : chart.stretches) {
    const double width = std::max(1.0, x(s.high) - x(s.low));  // a short one shows, too
    page.add(fmt::format(
        R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}" fill-opacity="0.25"/>)"
        "\n",
        std::min(x(s.low), page.right() - width), page.top(), width, page.bottom() - page.top(),
        hex(Colour::kOrange)));
  }
  for (const Band& band : chart.bands) page.add(area(band, x, y));
  for (const Line& line : chart.lines) page.add(curve(line, x, y));
  return page.finish();
}

std::string svg(const BarChart& chart) {
  std::vector<LegendEntry> legend;
  double highest = 0.0;
  for (const Bars& bars : chart.bars) {
    if (!bars.name.empty()) legend.push_back({bars.name, bars.colour, false, false});
    for (const double v : bars.values) highest = std::isfinite(v) ? std::max(highest, v) : highest;
  }
  Page page(chart.title, chart.width, chart.height, legend);
  const double top = chart.cut && *chart.cut < highest ? *chart.cut : highest;
  const Axis y{{0.0, top > 0.0 ? 1.08 * top : 1.0}, false, page.bottom(), page.top()};
  page.y_axis(y, chart.y_label);
  const double group =
      (page.right() - page.left()) / double(std::max<std::size_t>(1, chart.groups.size()));
  const double bar = 0.84 * group / double(std::max<std::size_t>(1, chart.bars.size()));
  for (std::size_t g = 0; g < chart.groups.size(); ++g) {
    const double begin = page.left() + group * (double(g) + 0.08);
    for (std::size_t b = 0; b < chart.bars.size(); ++b) {
      const Bars& bars = chart.bars[b];
      if (g >= bars.values.size() || !std::isfinite(bars.values[g])) continue;
      const double value = bars.values[g], x = begin + bar * double(b);
      const double high = y(std::min(value, top));
      page.add(rectangle(x + 1.0, high, bar - 2.0, page.bottom() - high, hex(bars.colour)));
      if (value > top) page.add(rectangle(x, high + 10.0, bar, 3.0, "#fff"));
      page.add(text(x + 0.5 * bar, high - 4.0, fmt::format("{:.{}f}", value, value < 9.95 ? 1 : 0),
                    "middle", 10));
    }
    std::string_view rest = chart.groups[g];
    for (double line = page.bottom() + 16.0; !rest.empty(); line += 14.0) {
      const auto end = std::min(rest.find('\n'), rest.size());
      page.add(text(begin + 0.42 * group, line, rest.substr(0, end), "middle"));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  return page.finish();
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
