// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/repeats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "statistics/median_to_sigma.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr std::size_t kRepeatBlock = 10;  // samples over which changes are of one size
constexpr double kCoarse = 0.01;          // chance of a repeat where they say nothing
constexpr double kSigmas = 5.0;           // of a count by chance
constexpr double kFewest = 5.0;           // repeats
constexpr double kTimes = 3.0;            // what is expected, which no model of noise gives well

// Of a normal change of this size, rounded to the step.
double chance_of_none(double step, double size) {
  return size > 0.0 ? std::erf(step / (2.0 * std::sqrt(2.0) * size)) : 1.0;
}

}  // namespace

Vector3 least_steps(const VectorSeries& series) {
  Vector3 step = Vector3::Constant(std::numeric_limits<double>::infinity());
  for (std::size_t k = 1; k < series.size(); ++k) {
    const Vector3 d = (series.v[k] - series.v[k - 1]).cwiseAbs();
    for (int axis = 0; axis < 3; ++axis) {
      if (d[axis] > 0.0) step[axis] = std::min(step[axis], d[axis]);
    }
  }
  return step;
}

bool made_by_rounding(const VectorSeries& series) {
  constexpr double kOneOrTwo = 2.5;  // steps: another axis may change at the same time
  const Vector3 step = least_steps(series);
  std::vector<double> steps;
  for (std::size_t k = 1; k < series.size(); ++k) {
    const Vector3 d = (series.v[k] - series.v[k - 1]).cwiseAbs();
    if (!d.isZero(0.0)) steps.push_back(d.cwiseQuotient(step).sum());
  }
  return !steps.empty() && median(std::move(steps)) < kOneOrTwo;
}

bool Repeats::beyond_chance() const {
  return double(seen) > kTimes * expected + kSigmas * std::sqrt(expected) + kFewest;
}

Repeats repeats_in(const VectorSeries& series) {
  Repeats out;
  const std::size_t n = series.size();
  if (n < 2) return out;
  const Vector3 step = least_steps(series);
  std::size_t counted = 0;
  for (std::size_t begin = 1; begin < n; begin += kRepeatBlock) {
    const std::size_t end = std::min(n, begin + kRepeatBlock);
    std::size_t repeats = 0;
    std::array<std::vector<double>, 3> changes;
    for (std::size_t k = begin; k < end; ++k) {
      const Vector3 d = (series.v[k] - series.v[k - 1]).cwiseAbs();
      repeats += d.isZero(0.0) ? 1 : 0;
      for (std::size_t axis = 0; axis < 3; ++axis) changes[axis].push_back(d[int(axis)]);
    }
    double chance = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      chance *= chance_of_none(step[int(axis)], kMedianToSigma * median(std::move(changes[axis])));
    }
    if (chance > kCoarse) continue;
    out.seen += repeats;
    out.expected += chance * double(end - begin);
    counted += end - begin;
  }
  out.share = double(out.seen) / double(std::max<std::size_t>(1, counted));
  return out;
}

}  // namespace magimu
