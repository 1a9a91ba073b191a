// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/plot/plot_frame.h"

namespace magimu::plot {
namespace {

constexpr double kNoteCharacter = 6.0;  // mean width at 11 pixels
constexpr const char* kNote = R"( fill="#555")";

// The beginning of a text, of so many characters, whole ones (UTF-8).
std::string shortened(const std::string& text, double characters) {
  double n = 0.0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins = (static_cast<unsigned char>(text[i]) & 0xC0) != 0x80;
    if (begins && ++n > characters) return text.substr(0, i) + "…";
  }
  return text;
}

double width_of(const std::string& text) {
  const auto begins = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
  return kNoteCharacter * double(std::ranges::count_if(text, begins));
}

std::size_t rows_to_last_bar(const RowChart& chart) {
  std::size_t n = chart.rows.size();
  while (n > 0 && !std::isfinite(chart.rows[n - 1].value)) --n;
  return n;
}

}  // namespace

std::string svg(const RowChart& chart) {
  std::vector<LegendEntry> legend;
  for (const auto& [name, colour] : chart.legend) legend.push_back({name, colour, false, false});
  double highest = std::max(chart.threshold.value_or(chart.low), chart.low);
  for (const RowChart::Row& row : chart.rows) {
    if (std::isfinite(row.value)) highest = std::max(highest, row.value);
  }
  const double low = chart.log && !(chart.low > 0.0) ? 0.1 : chart.low;
  if (highest <= low) highest = chart.log ? 10.0 * low : low + 1.0;

  // The frame's height follows from the rows; its top, from the legend.
  const double rows = chart.row_height * double(chart.rows.size()) + 8.0;
  const auto frame_of = [&](double height) {
    return Frame(chart.title, chart.width, height, legend, chart.names_width);
  };
  const Frame empty = frame_of(100.0);
  Frame frame = frame_of(empty.top() + rows + (100.0 - empty.bottom()) + 16.0);
  // To the right of the longest bar there is room for its note.
  const double air = 0.2;
  const double last =
      chart.log ? highest * std::pow(highest / low, air) : highest + air * (highest - low);
  const Axis x{{low, last}, chart.log, frame.left(), frame.right()};
  frame.x_axis(x, chart.x_label);
  // Below the last bar there is nothing to compare, and notes have the room to themselves.
  const double first_row = frame.top() + 18.0;  // above: the threshold's name
  const double line_end = first_row + chart.row_height * double(rows_to_last_bar(chart));
  const bool line = chart.threshold && x.shows(*chart.threshold);
  const double at = line ? x(*chart.threshold) : 0.0;
  if (line) {
    frame.add(fmt::format(R"(<line x1="{0:.1f}" y1="{1:.1f}" x2="{0:.1f}" y2="{2:.1f}" )"
                          R"(stroke="#333" stroke-width="1.5" stroke-dasharray="5 4"/>)"
                          "\n",
                          at, frame.top(), line_end));
    frame.add(text(at + 5.0, frame.top() + 11.0, chart.threshold_name, "start", 11));
  }
  double y = first_row;
  for (const RowChart::Row& row : chart.rows) {
    const double middle = y + 0.5 * chart.row_height, high = chart.row_height - 6.0;
    frame.add(text(frame.left() - 8.0, middle + 4.0, row.name, "end", 12,
                   row.colour == Colour::kGrey ? R"( fill="#767676")" : ""));
    double end = frame.left();
    if (std::isfinite(row.value)) {
      end = std::max(x(std::max(row.value, low)), frame.left() + 1.0);
      frame.add(rectangle(frame.left(), y + 3.0, end - frame.left(), high, hex(row.colour)));
    }
    // A note that would cross the threshold's line begins behind it.
    double from = end + 6.0;
    const bool crosses =
        line && y < line_end && from < at + 4.0 && from + width_of(row.note) > at - 4.0;
    if (crosses) from = at + 6.0;
    const double room = (frame.right() - from) / kNoteCharacter - 1.0;
    if (!row.note.empty() && room > 2.0) {
      frame.add(text(from, middle + 4.0, shortened(row.note, room), "start", 11, kNote));
    }
    y += chart.row_height;
  }
  return frame.finish();
}

}  // namespace magimu::plot
