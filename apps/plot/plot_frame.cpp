// SPDX-License-Identifier: BSD-3-Clause
#include "apps/plot/plot_frame.h"

#include <fmt/format.h>

#include <algorithm>

namespace magimu::plot {
namespace {

constexpr double kTitle = 28.0, kLegendRow = 18.0;
constexpr double kCharacter = 6.4;                       // mean width at 12 pixels, for the legend
constexpr double kTickHeight = 15.0, kTickWidth = 36.0;  // of a number, with air
constexpr int kTicks = 8, kTicksX = 10;

}  // namespace

const char* hex(Colour colour) {
  constexpr const char* kHex[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                  "#56B4E9", "#E69F00", "#767676"};
  return kHex[int(colour)];
}

std::string text(double x, double y, std::string_view content, const char* anchor, int size,
                 const char* more) {
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

Frame::Frame(const std::string& title, double width, double height,
             const std::vector<LegendEntry>& legend, double left)
    : width_(width), height_(height), left_(left) {
  out_ = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0:.0f} {1:.0f}" width="{0:.0f}" )"
      R"(height="{1:.0f}" font-family="Helvetica, Arial, sans-serif" fill="#333">)"
      "\n",
      width, height);
  out_ += rectangle(0.0, 0.0, width, height, "#fff");
  out_ += text(left, 19.0, title, "start", 14, R"( font-weight="bold")");
  double x = left, y = kTitle + 12.0;
  for (const LegendEntry& entry : legend) {
    const double wide = 34.0 + kCharacter * double(entry.name.size()) + 16.0;
    if (x > left && x + wide > right()) {
      x = left;
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

void Frame::y_axis(const Axis& y, const std::string& label) {
  const int at_most = std::clamp(int((bottom() - top()) / kTickHeight), 2, kTicks);
  for (const double v : y.log ? log_ticks(y.range) : ticks(y.range, at_most)) {
    add(segment(left(), y(v), right(), y(v), "#e4e4e4"));
    add(text(left() - 6.0, y(v) + 4.0, fmt::format("{:g}", v), "end"));
  }
  const double middle = 0.5 * (top() + bottom());
  add(text(14.0, middle, label, "middle", 12,
           fmt::format(R"~( transform="rotate(-90 14 {:.1f})")~", middle).c_str()));
}

void Frame::x_axis(const Axis& x, const std::string& label, const std::vector<Tick>& given) {
  const int at_most = std::clamp(int((right() - left()) / kTickWidth), 2, kTicksX);
  std::vector<Tick> all = given;
  if (given.empty()) {
    for (const double v : x.log ? log_ticks(x.range) : ticks(x.range, at_most)) {
      all.push_back({v, fmt::format("{:g}", v)});
    }
  }
  for (const Tick& tick : all) {
    add(segment(x(tick.at), top(), x(tick.at), bottom(), "#e4e4e4"));
    add(text(x(tick.at), bottom() + 16.0, tick.label, "middle"));
  }
  add(text(0.5 * (left() + right()), height_ - 10.0, label, "middle"));
}

std::string Frame::finish() const {
  return out_ + segment(left(), top(), left(), bottom(), "#444") +
         segment(left(), bottom(), right(), bottom(), "#444") + "</svg>\n";
}

}  // namespace magimu::plot
