// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/diagnosis_disturbance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/plot/plot.h"
#include "apps/say/diagnosis_answer.h"

namespace magimu::apps {
namespace {

constexpr std::size_t kMostPoints = 1500;  // of a curve; more show nothing in 760 pixels
constexpr double kShownBand = 2.0;         // standard deviations

bool in_field(const MissingSeries& s) { return s.frame == "navigation"; }

std::string axis_name(const MissingSeries& s, int axis) {
  constexpr const char* kField[] = {"east", "north", "up"};
  return in_field(s) ? kField[axis] : std::string(1, "xyz"[axis]);
}

}  // namespace

std::string disturbance_picture(const MissingSeries& s) {
  const bool rate = s.unit == "rad/s";
  const double scale = rate ? 180.0 / M_PI : 1.0;
  const std::string unit = rate ? "deg/s" : s.unit;
  const std::size_t step = std::max<std::size_t>(1, s.t.size() / kMostPoints);
  std::string out;
  for (int axis = 0; axis < 3; ++axis) {
    plot::Chart chart;
    chart.y_label = axis_name(s, axis) + ", " + unit;
    chart.height = 150.0;
    if (axis == 2) {
      chart.x_label = "time, s";
      chart.height = 180.0;
    }
    plot::Band band;
    plot::Line line, zero;
    for (std::size_t k = 0; k < s.t.size(); k += step) {
      const double mean = scale * s.mean[k][axis], sigma = scale * s.sigma[k][axis];
      band.x.push_back(s.t[k]);
      band.low.push_back(mean - kShownBand * sigma);
      band.high.push_back(mean + kShownBand * sigma);
      line.x.push_back(s.t[k]);
      line.y.push_back(mean);
    }
    if (!line.x.empty()) {
      zero.x = {line.x.front(), line.x.back()};
      zero.y = {0.0, 0.0};
      zero.colour = plot::Colour::kGrey;
      zero.width = 1.0;
    }
    band.colour = plot::Colour::kSky;
    chart.bands = {band};
    chart.lines = {zero, line};
    out += plot::svg(chart);
  }
  return out;
}

std::string disturbance_caption(const MissingSeries& s) {
  const std::string where =
      in_field(s) ? "the field (east, magnetic north, up) would have to depart by this"
                  : "this would have to be added to the readings of the " + sensor_name(s.channel) +
                        " (its own axes)";
  return fmt::format(
      "{}: so that the simulation predicts the data, {}. The shaded band is two standard "
      "deviations to each side; where it holds zero nothing is missing.",
      s.recording, where);
}

}  // namespace magimu::apps
