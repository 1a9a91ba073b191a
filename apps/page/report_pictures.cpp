// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/report_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/page/residual_statistics.h"
#include "apps/plot/plot.h"
#include "calibration/use/apply.h"

namespace magimu::apps {
namespace {

using plot::Colour;

constexpr std::size_t kPoints = 900;  // of a cloud
constexpr int kStretches = 450;       // of time
constexpr int kRings = 6, kSectors = 8;
// A frame's margins, so that a unit is as long upward as to the right.
constexpr double kMarginX = 78.0, kMarginY = 96.0, kMarginYPlain = 84.0, kSquare = 222.0;

// Single points: a line that is interrupted after each.
plot::Line dots(const std::string& name, const std::vector<double>& x, const std::vector<double>& y,
                Colour colour, double width) {
  plot::Line out{.name = name, .colour = colour, .width = width};
  for (std::size_t i = 0; i < x.size(); ++i) {
    out.x.insert(out.x.end(), {x[i], NAN});
    out.y.insert(out.y.end(), {y[i], NAN});
  }
  return out;
}

plot::Line circle(double radius, const std::string& name) {
  plot::Line out{.name = name, .colour = Colour::kGrey, .width = 1.5};
  for (int i = 0; i <= 120; ++i) {
    out.x.push_back(radius * std::cos(i * M_PI / 60.0));
    out.y.push_back(radius * std::sin(i * M_PI / 60.0));
  }
  return out;
}

std::vector<double> axis_of(const std::vector<Vector3>& v, int axis) {
  std::vector<double> out;
  for (const Vector3& x : v) out.push_back(x[axis]);
  return out;
}

// About kPoints of all samples.
std::vector<Vector3> thinned(const std::vector<const Recording*>& recordings, std::size_t m) {
  std::size_t all = 0;
  for (const Recording* r : recordings) all += r->mag[m].size();
  const std::size_t every = std::max<std::size_t>(1, all / kPoints);
  std::vector<Vector3> out;
  for (const Recording* r : recordings) {
    for (std::size_t k = 0; k < r->mag[m].size(); k += every) out.push_back(r->mag[m].v[k]);
  }
  return out;
}

// Means over stretches of time; a NaN where time runs backward (the next recording).
Curve means(const std::vector<double>& t, const std::vector<double>& y) {
  Curve out;
  const std::size_t every = std::max<std::size_t>(1, t.size() / kStretches);
  for (std::size_t k = 0; k < t.size(); k += every) {
    const std::size_t end = std::min(t.size(), k + every);
    double sum = 0.0;
    for (std::size_t i = k; i < end; ++i) sum += y[i];
    const bool back = !out.x.empty() && t[k] < out.x.back();
    out.x.push_back(0.5 * (t[k] + t[end - 1]));
    out.y.push_back(back ? NAN : sum / double(end - k));
  }
  return out;
}

// Directions in the sensor's axes: of up, or of magnetic north's field line.
std::vector<Vector3> directions(const Calibration& c, bool gravity) {
  std::vector<Vector3> out;
  for (std::size_t r = 0; r < c.trajectories.size(); ++r) {
    const double dip = r < c.fields.size() ? c.fields[r].dip_rad : c.parameters.dip_rad;
    const Vector3 fixed = gravity ? Vector3(Vector3::UnitZ()) : unit_field(dip);
    for (const Rot3& nRb : c.trajectories[r].nRb) out.push_back(nRb.unrotate(fixed));
  }
  return out;
}

}  // namespace

std::vector<std::string> sphere_pictures(const Calibration& c,
                                         const std::vector<const Recording*>& recordings,
                                         std::size_t m) {
  const std::vector<Vector3> raw = thinned(recordings, m);
  std::vector<Vector3> corrected;
  for (const Vector3& v : raw) corrected.push_back(corrected_mag(c, m, v));
  double limit = 1.15 * c.strength_uT;
  for (const Vector3& v : raw) limit = std::max(limit, 1.05 * v.cwiseAbs().maxCoeff());
  std::vector<std::string> out;
  for (const auto& [x, y] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    plot::Chart chart;
    chart.title = fmt::format("{} and {}, uT", "xyz"[x], "xyz"[y]);
    chart.x_label = std::string(1, "xyz"[x]);
    chart.y_label = std::string(1, "xyz"[y]);
    chart.width = kSquare + kMarginX;
    chart.height = kSquare + kMarginY;
    chart.x_range = chart.y_range = plot::Range{-limit, limit};
    chart.lines.push_back(dots("raw", axis_of(raw, x), axis_of(raw, y), Colour::kVermilion, 2.6));
    chart.lines.push_back(
        dots("corrected", axis_of(corrected, x), axis_of(corrected, y), Colour::kBlue, 2.6));
    chart.lines.push_back(circle(c.strength_uT, ""));
    out.push_back(plot::svg(chart));
  }
  return out;
}

std::string length_picture(const Calibration& c, const std::vector<const Recording*>& recordings,
                           std::size_t m) {
  plot::Chart chart;
  chart.title = "Length of the readings, means of neighbouring ones";
  chart.x_label = "time, s";
  chart.y_label = "uT";
  chart.width = 880.0;
  chart.height = 240.0;
  std::vector<double> t, raw, corrected;
  for (const Recording* r : recordings) {
    for (std::size_t k = 0; k < r->mag[m].size(); ++k) {
      t.push_back(r->mag[m].t[k]);
      raw.push_back(r->mag[m].v[k].norm());
      corrected.push_back(corrected_mag(c, m, r->mag[m].v[k]).norm());
    }
  }
  const Curve before = means(t, raw), after = means(t, corrected);
  chart.lines.push_back(
      {.name = "raw", .x = before.x, .y = before.y, .colour = Colour::kVermilion, .width = 1.5});
  chart.lines.push_back(
      {.name = "corrected", .x = after.x, .y = after.y, .colour = Colour::kBlue, .width = 1.5});
  if (!after.x.empty()) {
    chart.lines.push_back({.name = "field",
                           .x = {after.x.front(), after.x.back()},
                           .y = {c.strength_uT, c.strength_uT},
                           .colour = Colour::kGrey,
                           .dashed = true});
  }
  for (const Disturbance& d : c.disturbances) chart.stretches.push_back({d.begin_s, d.end_s});
  if (!c.disturbances.empty()) chart.stretches_name = "disturbed";
  return plot::svg(chart);
}

std::string convergence_picture(const Calibration& c) {
  plot::Chart chart;
  chart.title = "Convergence of the last stage";
  chart.x_label = "iteration";
  chart.y_label = "distance to the optimum";
  chart.width = 880.0;
  chart.height = 240.0;
  chart.log_y = true;
  plot::Line cost{
      .name = "cost above its final value, share", .colour = Colour::kBlue, .width = 2.0};
  plot::Line step{
      .name = "step, largest in standard deviations", .colour = Colour::kVermilion, .width = 2.0};
  const double final_cost = c.fit.cost_final;
  for (const IterationRecord& r : c.fit.trace) {
    if (!r.accepted) continue;
    cost.x.push_back(r.iteration);
    cost.y.push_back(std::max((r.cost - final_cost) / final_cost, 1e-14));
    step.x.push_back(r.iteration);
    step.y.push_back(r.step_sigma > 0.0 ? r.step_sigma : NAN);
  }
  chart.lines = {cost, step};
  if (cost.x.size() < 2) chart.x_range = plot::Range{0.0, 2.0};
  return plot::svg(chart);
}

std::string coverage_picture(const Calibration& c, bool gravity) {
  const std::vector<Vector3> all = directions(c, gravity);
  const std::size_t every = std::max<std::size_t>(1, all.size() / kPoints);
  std::vector<double> longitude, height;
  for (std::size_t k = 0; k < all.size(); k += every) {
    longitude.push_back(std::atan2(all[k][1], all[k][0]) / kDegree);
    height.push_back(all[k][2]);
  }
  plot::Chart chart;
  chart.title = gravity ? "Up, in the sensor's axes" : "The field, in the sensor's axes";
  chart.x_label = "from x toward y, deg";
  chart.y_label = "z (equal areas)";
  chart.width = 432.0;
  chart.height = 216.0 + kMarginYPlain;
  chart.x_range = plot::Range{-180.0, 180.0};
  chart.y_range = plot::Range{-1.0, 1.0};
  chart.lines.push_back(dots("", longitude, height, Colour::kBlue, 2.5));
  return plot::svg(chart);
}

double coverage(const Calibration& c, bool gravity) {
  std::set<int> seen;
  for (const Vector3& v : directions(c, gravity)) {
    const int ring = std::clamp(int((v[2] + 1.0) / 2.0 * kRings), 0, kRings - 1);
    const double turn = (std::atan2(v[1], v[0]) + M_PI) / (2.0 * M_PI);
    seen.insert(ring * kSectors + std::clamp(int(turn * kSectors), 0, kSectors - 1));
  }
  return double(seen.size()) / double(kRings * kSectors);
}

}  // namespace magimu::apps
