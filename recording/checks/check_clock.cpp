// SPDX-License-Identifier: BSD-3-Clause
// A sensor that is written more often than it measures: its samples repeat, or a logger has put
// them onto straight lines between its own. Such samples carry nothing new, and a fit that counts
// them is too sure of itself.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "recording/checks/interpolated.h"
#include "recording/checks/quality_checks.h"
#include "recording/checks/rounding.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kManyRepeats = 0.3;  // share of samples; a few are chance
constexpr double kManyOnLines = 0.3;  // likewise
constexpr double kOnLine =
    1e-3;  // second difference over a large one: below, the sample is on the line
constexpr std::size_t kEnoughForClock = 50;  // samples
constexpr double kQuantum = 2.01;  // steps: rounding alone makes second differences as large
constexpr double kFineQuantum =
    0.02;  // step over a large second difference: above, lines cannot be told
constexpr double kLargeBend = 0.97;  // quantile

// The step in which the numbers are written: the least change of any axis; a double's own
// resolution is no step.
double quantum(const VectorSeries& s) {
  double least = 1e300, size = 0.0;
  for (std::size_t k = 1; k < s.size(); ++k) {
    size = std::max(size, s.v[k].cwiseAbs().maxCoeff());
    for (int i = 0; i < 3; ++i) {
      const double d = std::abs(s.v[k][i] - s.v[k - 1][i]);
      if (d > 1e-12 * size) least = std::min(least, d);
    }
  }
  return least < 1e300 ? least : 0.0;
}

// Whether the lines meet at samples: one bend where they do. Where they meet between two samples
// both have a bend.
bool knots_on_samples(const std::vector<double>& bends, double limit) {
  int single = 0, all = 0;
  for (std::size_t k = 1; k + 1 < bends.size(); ++k) {
    if (bends[k] <= limit || bends[k - 1] > limit) continue;
    ++all;
    single += bends[k + 1] <= limit ? 1 : 0;
  }
  return 2 * single > all;
}

Issue rounding_issue(const NamedSeries& sensor, double step) {
  return {"rounding",
          sensor.name,
          -1,
          Severity::kCaution,
          0.0,
          0.0,
          fmt::format("{} comes in steps of {:.3g} {}, coarser than its noise: where it changes "
                      "slowly, readings stay wrong by the same part of a step, which counts as so "
                      "much more noise here",
                      sensor.name, step, sensor.unit()),
          "write more digits, or choose a smaller range of the sensor"};
}

}  // namespace

std::vector<Issue> check_clock(const NamedSeries& sensor) {
  const VectorSeries& s = *sensor.series;
  if (s.size() < kEnoughForClock) return {};
  if (!sensor.is_mag()) {
    if (const auto steps = coarse_steps(s)) return {rounding_issue(sensor, steps->maxCoeff())};
  }
  const double rate = s.rate_hz();
  std::size_t repeats = 0;
  for (std::size_t k = 1; k < s.size(); ++k) repeats += s.v[k] == s.v[k - 1] ? 1 : 0;
  const double repeated = double(repeats) / double(s.size() - 1);
  if (repeated > kManyRepeats) {
    return {
        {"repeats", sensor.name, -1, sensor.is_mag() ? Severity::kNote : Severity::kCaution, 0.0,
         0.0,
         fmt::format("{:.0f} % of the samples of {} repeat the one before: its own rate is about "
                     "{:.3g} Hz, not {:.3g}",
                     100.0 * repeated, sensor.name, rate * (1.0 - repeated), rate),
         sensor.is_mag() ? "the repeats are left out of a calibration"
                         : "log each sample once, with the time at which it was measured"}};
  }
  std::vector<double> bends;
  for (std::size_t k = 1; k + 1 < s.size(); ++k) {
    bends.push_back((s.v[k + 1] - 2.0 * s.v[k] + s.v[k - 1]).norm());
  }
  // The usual bend where there is one, however few samples have one; blows do not count.
  const double large = quantile(bends, kLargeBend);
  const double step = kQuantum * std::sqrt(3.0) * quantum(s);
  const double limit = std::max(kOnLine * large, step < kFineQuantum * large ? step : 0.0);
  // Where nothing moves every sample lies on a line, so only moving samples count.
  std::size_t on_line = 0, moving = 0;
  for (std::size_t k = 0; k < bends.size(); ++k) {
    if (bends[k] > limit) continue;
    ++on_line;
    moving += s.v[k + 2] != s.v[k + 1] ? 1 : 0;
  }
  const double share = double(on_line) / double(bends.size());
  const bool many = double(moving) >= kManyOnLines * double(bends.size());
  std::optional<VectorSeries> readings;
  if (sensor.is_mag()) readings = readings_of_lines(s);
  if (!many && !readings) return {};
  const double own = readings ? readings->rate_hz()
                              : rate * (1.0 - share) / (knots_on_samples(bends, limit) ? 1.0 : 2.0);
  const std::string lines =
      many ? fmt::format(
                 "{:.0f} % of the samples of {} lie on straight lines between their "
                 "neighbours",
                 100.0 * share, sensor.name)
           : fmt::format("the samples of {} lie on straight lines that meet between them",
                         sensor.name);
  const std::string done =
      readings ? fmt::format(
                     "a calibration uses the {} readings at which the lines meet, and no "
                     "others; better, ",
                     readings->size())
               : std::string();
  return {{"interpolation", sensor.name, -1, Severity::kCaution, 0.0, 0.0,
           fmt::format("{}: they are interpolated from a clock of about {:.3g} Hz, not measured at "
                       "{:.3g} Hz",
                       lines, own, rate),
           done + "write the sensor's own samples with their own times, and leave its fields empty "
                  "between them"}};
}

}  // namespace magimu
