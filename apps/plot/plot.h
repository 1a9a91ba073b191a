// SPDX-License-Identifier: BSD-3-Clause
// Pictures as SVG text, to stand alone or inside an HTML page (no ids, no style sheet, no script):
// curves over one axis, with shaded bands and stretches, and bars in groups. Light background,
// colours that colour-blind readers can tell apart (Okabe and Ito).
//
//   plot::Chart chart;
//   chart.title = "Orientation error";
//   chart.x_label = "time, s";
//   chart.lines.push_back({.name = "ours", .x = t, .y = error_deg});
//   write_atomically("error.svg", plot::svg(chart));
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/plot/plot_axis.h"

namespace magimu::plot {

enum class Colour { kBlue, kVermilion, kGreen, kPurple, kSky, kOrange, kGrey };

// A curve; where x or y is not a number (on a logarithmic axis: not positive) it is interrupted.
struct Line {
  std::string name = {};  // in the legend; empty: not there
  std::vector<double> x = {}, y = {};
  Colour colour = Colour::kBlue;
  double width = 1.5;  // pixels
  bool dashed = false;
};

// The area between two curves, such as a standard deviation to both sides.
struct Band {
  std::string name = {};
  std::vector<double> x = {}, low = {}, high = {};
  Colour colour = Colour::kBlue;
};

// A place on an axis, and what is written there.
struct Tick {
  double at = 0.0;
  std::string label;
};

struct Chart {
  std::string title, x_label, y_label;
  std::vector<Line> lines;
  std::vector<Band> bands;
  std::vector<Range> stretches;  // of x, shaded from top to bottom
  std::string stretches_name;    // in the legend
  // Points beyond a given range are drawn on the frame; nothing given: whatever holds the curves.
  std::optional<Range> x_range, y_range;
  std::vector<Tick> x_ticks = {};  // none: round numbers
  bool log_x = false, log_y = false;
  double width = 760.0, height = 280.0;  // pixels
};

struct Bars {
  std::string name;
  std::vector<double> values;  // one a group, at least 0; not a number: no bar
  Colour colour = Colour::kBlue;
};

struct BarChart {
  std::string title, y_label;
  std::vector<std::string> groups;  // names; a line break is one
  std::vector<Bars> bars;           // side by side in every group, each with its value above
  std::optional<double> cut;        // higher bars end here, with a gap that says so
  double width = 760.0, height = 320.0;
};

// Bars to the right, one a row, from the strongest down; for a ranking with long names.
struct RowChart {
  struct Row {
    std::string name;
    double value = 0.0;  // not a number: no bar
    Colour colour = Colour::kBlue;
    std::string note;  // behind the bar, cut off where it would leave the picture
  };
  std::string title, x_label;
  std::vector<Row> rows;
  std::vector<std::pair<std::string, Colour>> legend;
  std::optional<double> threshold;  // a dashed line from the top to the last bar
  std::string threshold_name;
  bool log = false;
  double low = 0.0;  // where bars begin; above 0 on a logarithmic axis
  double names_width = 230.0, row_height = 21.0, width = 860.0;
};

std::string svg(const Chart& chart);
std::string svg(const BarChart& chart);
std::string svg(const RowChart& chart);

// Text fit for SVG and HTML.
std::string escaped(std::string_view text);

}  // namespace magimu::plot
