// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/interpolated.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "recording/checks/repeats.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr std::size_t kEnoughReadings = 20;
// Of the readings' number: lines that do not meet, where a logger paused or a reading was lost.
constexpr double kFewMisfits = 0.05;
constexpr double kOfACurve = 0.2;       // of the readings: as many meetings may look like a curve
constexpr double kFewerReadings = 0.6;  // of the samples: each line has two samples or nearly
constexpr double kStraight = 1e-3;      // of a large change of slope: the times' decimals
// Rounding to a step moves a second difference by two steps at most, and by sqrt(3) in space.
constexpr double kRoundedBend = 3.48;
constexpr double kCoarseBend = 0.1;  // of a large change: directions then agree by chance
constexpr double kLargeBendShare = 0.9;
constexpr double kLinePause = 3.0;  // usual intervals

// What the slope changes by at each sample but the first and the last, times the usual interval.
std::vector<Vector3> bends_of(const VectorSeries& s, double usual) {
  std::vector<Vector3> out(s.size(), Vector3::Zero());
  for (std::size_t k = 1; k + 1 < s.size(); ++k) {
    out[k] = usual * ((s.v[k + 1] - s.v[k]) / (s.t[k + 1] - s.t[k]) -
                      (s.v[k] - s.v[k - 1]) / (s.t[k] - s.t[k - 1]));
  }
  return out;
}

}  // namespace

std::optional<VectorSeries> readings_of_lines(const VectorSeries& s) {
  if (s.size() < 3 * kEnoughReadings) return std::nullopt;
  std::vector<double> intervals;
  for (std::size_t k = 1; k < s.size(); ++k) intervals.push_back(s.t[k] - s.t[k - 1]);
  const double usual = median(std::move(intervals));
  if (!(usual > 0.0)) return std::nullopt;
  const std::vector<Vector3> bends = bends_of(s, usual);
  std::vector<double> sizes;
  for (std::size_t k = 1; k + 1 < s.size(); ++k) {
    const double size = bends[k].norm();
    if (size > 0.0) sizes.push_back(size);
  }
  if (sizes.size() < kEnoughReadings) return std::nullopt;
  const double large = quantile(std::move(sizes), kLargeBendShare);
  const Vector3 steps = least_steps(s);
  double step = 0.0;
  for (const double axis : steps) step = std::max(step, std::isfinite(axis) ? axis : 0.0);
  const double limit = std::max(kStraight * large, kRoundedBend * step);
  if (limit > kCoarseBend * large) return std::nullopt;

  // A curve without noise bends alike at all neighbours, lines at those of one meeting alone.
  const auto alike = [&](std::size_t k) {
    const Vector3 along = (bends[k] + bends[k + 1]).normalized();
    return along.dot(bends[k]) > 0.0 && along.dot(bends[k + 1]) > 0.0 &&
           (bends[k] - along.dot(bends[k]) * along).norm() <= limit;
  };
  VectorSeries out;
  std::size_t misfits = 0, of_a_curve = 0;
  for (std::size_t k = 1; k + 1 < s.size(); ++k) {
    if (bends[k].norm() <= limit) continue;
    const bool last = k + 2 >= s.size();
    if (last || bends[k + 1].norm() <= limit) {  // the lines meet at the sample
      out.push_back(s.t[k], s.v[k]);
      continue;
    }
    const bool meet = alike(k) && s.t[k + 1] - s.t[k] < kLinePause * usual;
    if (!meet) {
      ++misfits;
      continue;
    }
    if (k + 3 < s.size() && bends[k + 2].norm() > limit && alike(k + 1)) ++of_a_curve;
    const double before = bends[k].norm(), after = bends[k + 1].norm();
    const double w = after / (before + after);
    const double tau = w * (s.t[k + 1] - s.t[k]);
    const Vector3 slope = (s.v[k] - s.v[k - 1]) / (s.t[k] - s.t[k - 1]);
    out.push_back(s.t[k] + tau, s.v[k] + tau * slope);
    ++k;  // that one's change is this one's
  }
  const double readings = double(out.size());
  if (double(of_a_curve) > kOfACurve * readings) return std::nullopt;
  if (out.size() < kEnoughReadings || double(misfits) > kFewMisfits * readings ||
      readings > kFewerReadings * double(s.size())) {
    return std::nullopt;
  }
  return out;
}

}  // namespace magimu
