// SPDX-License-Identifier: BSD-3-Clause
// What every picture (plot.h) has around its content, title, legend, axes, and the shapes that all
// are made of. For the files that draw; others want plot.h.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/plot/plot.h"

namespace magimu::plot {

const char* hex(Colour colour);

// size in pixels; more: further attributes, with a space before each.
std::string text(double x, double y, std::string_view content, const char* anchor, int size = 12,
                 const char* more = "");
std::string segment(double x1, double y1, double x2, double y2, const char* colour);
std::string rectangle(double x, double y, double width, double height, const std::string& fill);

struct LegendEntry {
  std::string name;
  Colour colour;
  bool area, dashed;
};

class Frame {
 public:
  // left: margin, pixels.
  Frame(const std::string& title, double width, double height,
        const std::vector<LegendEntry>& legend, double left = 62.0);

  double top() const { return top_; }
  double left() const { return left_; }
  double right() const { return width_ - 16.0; }
  double bottom() const { return height_ - 46.0; }
  void add(const std::string& svg) { out_ += svg; }

  // Grid lines with their numbers, and what they mean.
  void y_axis(const Axis& y, const std::string& label);
  // given: instead of round numbers.
  void x_axis(const Axis& x, const std::string& label, const std::vector<Tick>& given = {});
  std::string finish() const;

 private:
  double width_, height_, left_, top_;
  std::string out_;
};

}  // namespace magimu::plot
