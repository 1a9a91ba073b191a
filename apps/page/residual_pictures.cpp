// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/residual_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/residual_statistics.h"
#include "apps/plot/plot.h"

namespace magimu::apps {
namespace {

using plot::Colour;

constexpr int kTraceStretches = 450;  // of time, two points each: as fine as the picture
constexpr int kLags = 100;
constexpr double kBand = 2.576;  // sigmas: 99 % of normal noise lies within

// Orange-red before, blue after; without an "after" the one curve is blue.
struct Look {
  std::string name;
  Colour colour;
};
Look look_before(bool extended) {
  return extended ? Look{"before", Colour::kVermilion} : Look{"residual", Colour::kBlue};
}
const Look kAfter{"after", Colour::kBlue};

std::vector<double> one_axis(const std::vector<Vector3>& v, int axis) {
  std::vector<double> out;
  for (const Vector3& r : v) out.push_back(r[axis]);
  return out;
}

plot::Line line(const Look& look, const Curve& curve, double width) {
  return {.name = look.name, .x = curve.x, .y = curve.y, .colour = look.colour, .width = width};
}

// Largest residual on the scale, sigmas: all but 0.1 % of the samples fit, and so does the band.
double usual_extreme(const std::vector<Vector3>& residuals) {
  std::vector<double> sizes;
  for (const Vector3& r : residuals) {
    if (r.allFinite()) sizes.push_back(r.cwiseAbs().maxCoeff());
  }
  if (sizes.empty()) return 1.5 * kBand;
  const auto at = sizes.begin() + std::ptrdiff_t(0.999 * double(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  return std::max(1.5 * kBand, 1.1 * *at);
}

std::string trace_picture(const ResidualTrace& trace, bool extended) {
  std::string out;
  const double limit = usual_extreme(trace.before);  // one scale for all
  for (int axis = 0; axis < 3; ++axis) {
    plot::Chart chart;
    chart.y_range = {-limit, limit};
    chart.title = fmt::format("{} axis", "xyz"[axis]);
    chart.y_label = "sigma";
    chart.x_label = "time, s";
    chart.width = 880.0;
    chart.height = axis == 0 ? 190.0 : 165.0;
    const auto add = [&](const Look& look, const std::vector<Vector3>& v) {
      chart.lines.push_back(line(look, envelope(trace.t, one_axis(v, axis), kTraceStretches), 1.0));
      if (axis > 0) chart.lines.back().name.clear();  // one legend for all three
    };
    add(look_before(extended), trace.before);
    if (extended) add(kAfter, trace.after);
    double begin = INFINITY, end = -INFINITY;
    for (const double t : trace.t) {
      begin = std::min(begin, t);
      end = std::max(end, t);
    }
    if (begin < end) {
      chart.bands.push_back({.name = axis == 0 ? "99 % of noise" : "",
                             .x = {begin, end},
                             .low = {-kBand, -kBand},
                             .high = {kBand, kBand},
                             .colour = Colour::kGrey});
    }
    out += plot::svg(chart);
  }
  return out;
}

std::string correlation_picture(const ResidualTrace& trace, bool extended, double interval) {
  plot::Chart chart;
  chart.title = "How long a residual is remembered";
  chart.x_label = "time between two samples, s";
  chart.y_label = "correlation";
  chart.width = 420.0;
  chart.height = 260.0;
  const Curve before = autocorrelation(trace.before, interval, kLags);
  if (!before.x.empty()) {
    const double band = kBand / std::sqrt(3.0 * double(trace.before.size()));
    chart.bands.push_back({.name = "white noise",
                           .x = {0.0, before.x.back()},
                           .low = {-band, -band},
                           .high = {band, band},
                           .colour = Colour::kGrey});
  }
  chart.lines.push_back(line(look_before(extended), before, 1.5));
  if (extended) {
    chart.lines.push_back(line(kAfter, autocorrelation(trace.after, interval, kLags), 1.5));
  }
  return plot::svg(chart);
}

std::string spectrum_picture(const ResidualTrace& trace, bool extended, double interval) {
  plot::Chart chart;
  chart.title = "Spectrum of the residual";
  chart.x_label = "frequency, Hz";
  chart.y_label = "power (white noise: 1)";
  chart.width = 420.0;
  chart.height = 260.0;
  chart.log_x = chart.log_y = true;
  const Curve before = spectrum(trace.before, interval);
  if (!before.x.empty()) {
    chart.lines.push_back({.name = "white noise",
                           .x = {before.x.front(), before.x.back()},
                           .y = {1.0, 1.0},
                           .colour = Colour::kGrey,
                           .dashed = true});
  }
  chart.lines.push_back(line(look_before(extended), before, 1.5));
  if (extended) chart.lines.push_back(line(kAfter, spectrum(trace.after, interval), 1.5));
  return plot::svg(chart);
}

}  // namespace

ResidualPictures residual_pictures(const ResidualTrace& trace, bool extended) {
  const bool both = extended && !trace.after.empty();
  const double interval = median_interval(trace.t);
  return {trace_picture(trace, both), correlation_picture(trace, both, interval),
          spectrum_picture(trace, both, interval)};
}

}  // namespace magimu::apps
