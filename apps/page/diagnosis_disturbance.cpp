// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/diagnosis_disturbance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/plot/plot.h"
#include "apps/say/diagnosis_answer.h"
#include "diagnosis/conclude/place.h"
#include "diagnosis/result/sentence_words.h"
#include "graph/decompositions.h"

namespace magimu::apps {
namespace {

constexpr std::size_t kMostPoints = 1500;  // of a curve; more show nothing in 760 pixels
constexpr double kShownBand = 2.0;         // standard deviations

bool in_field(const MissingSeries& s) { return s.frame == "navigation"; }

std::string axis_name(const MissingSeries& s, int axis) {
  constexpr const char* kField[] = {"east", "north", "up"};
  return in_field(s) ? kField[axis] : std::string(1, "xyz"[axis]);
}

// A dot each, as wide as this.
plot::Line dots(const std::vector<double>& x, const std::vector<double>& y, double width) {
  plot::Line line;
  for (std::size_t k = 0; k < x.size(); ++k) {
    line.x.insert(line.x.end(), {x[k] - 0.5 * width, x[k] + 0.5 * width, NAN});
    line.y.insert(line.y.end(), {y[k], y[k], NAN});
  }
  return line;
}

// East, north or up, and the direction in space: what of the field changes most, and where to.
struct Steepest {
  int component = 0;
  Vector3 along = Vector3::UnitX();
};
Steepest steepest(const PlaceCheck& place) {
  const double n = double(place.points.size());
  Vector3 middle = Vector3::Zero(), field = Vector3::Zero();
  for (const PlaceCheck::Point& p : place.points) {
    middle += p.place / n;
    field += p.fitted / n;
  }
  Matrix3 places = 1e-12 * Matrix3::Identity(), both = Matrix3::Zero();
  Vector3 power = Vector3::Zero();
  for (const PlaceCheck::Point& p : place.points) {
    places += (p.place - middle) * (p.place - middle).transpose();
    both += (p.place - middle) * (p.fitted - field).transpose();
    power += (p.fitted - field).cwiseAbs2();
  }
  Steepest out;
  power.maxCoeff(&out.component);
  const Vector3 slope = places.llt().solve(Vector3(both.col(out.component)));
  if (slope.norm() > 0.0) out.along = slope.normalized();
  return out;
}

}  // namespace

std::string place_picture(const PlaceCheck& place) {
  const Steepest s = steepest(place);
  std::vector<double> x, measured, fitted;
  for (const PlaceCheck::Point& p : place.points) {
    x.push_back(p.place.dot(s.along));
    measured.push_back(p.measured[s.component]);
    fitted.push_back(p.fitted[s.component]);
  }
  if (x.empty()) return {};
  const auto [low, high] = std::ranges::minmax(x);
  const double width = 0.004 * (high - low);
  constexpr const char* kField[] = {"east", "north", "up"};
  plot::Chart chart;
  chart.x_label = fmt::format("place along ({:.1f} east, {:.1f} north, {:.1f} up), m", s.along.x(),
                              s.along.y(), s.along.z());
  chart.y_label = std::string("field, ") + kField[s.component] + ", uT";
  chart.lines = {dots(x, measured, width), dots(x, fitted, width)};
  chart.lines[0].name = "departure";
  chart.lines[0].colour = plot::Colour::kGrey;
  chart.lines[1].name = "function of the place";
  for (plot::Line& line : chart.lines) line.width = 3.0;
  return plot::svg(chart);
}

std::string place_caption(const PlaceCheck& place) {
  return fmt::format(
      "The field's departure against the estimated place, a dot a time. What differs from place to "
      "place comes back where the sensor comes back: a polynomial of order {} in all three "
      "directions.",
      place.order);
}

std::vector<std::string> place_words(const Diagnosis& d) {
  if (!d.place) return {};
  const PlaceCheck& p = *d.place;
  const AtRest rest = d.field_at_rest.value_or(AtRest{});
  const auto sign = [](bool yes) { return yes ? "yes" : "no"; };
  return {
      fmt::format("(a) Nothing else explains the readings as well: {}. A function of the place is "
                  "{} {} {}; {} ahead decide.",
                  sign(p.ahead), nats(std::abs(p.ahead_nats)),
                  p.ahead_nats < 0.0 ? "behind" : "ahead of", p.rival, kDecided),
      rest.rests == 0
          ? std::string("(b) The departure stays while the sensor rests: not shown, there is no "
                        "rest of 3 s and more.")
          : fmt::format("(b) The departure stays while the sensor rests: {}. In {} rest{} it "
                        "changed by {:.2g} uT at the most ({:.1f} standard deviations).",
                        sign(p.stays), rest.rests, rest.rests == 1 ? "" : "s", rest.change_uT,
                        rest.change_sigmas),
      fmt::format(
          "(c) It comes back where the sensor comes back: {}. Of {} blocks of {:.0f} s that "
          "were left out, {} {} predicted better by a function of the place; all together are "
          "{} {}.",
          sign(p.comes_back), p.blocks, p.block_s, p.blocks_better,
          p.blocks_better == 1 ? "is" : "are", nats(std::abs(p.predicts_nats())),
          p.predicts_nats() < 0.0 ? "worse" : "better")};
}

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
                  : "this would have to be added to the readings of the " + in_words(s.channel) +
                        " (its own axes)";
  return fmt::format(
      "{}: so that the simulation predicts the data, {}. The shaded band is two standard "
      "deviations to each side; where it holds zero nothing is missing.",
      s.recording, where);
}

}  // namespace magimu::apps
