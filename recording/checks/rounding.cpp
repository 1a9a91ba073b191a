// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/rounding.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "recording/checks/quality_checks.h"

namespace magimu {
namespace {

constexpr std::size_t kSlowStretch = 10;  // samples
constexpr double kFewSteps = 2.5;         // of an axis that changes slowly there
// Share of such stretches: noise of 0.3 steps leaves so many steady, and a sixth of what rounding
// does to the mean of slow readings.
constexpr double kSteady = 0.33;
constexpr double kManySteps = 10.0;   // that an axis must have gone over, or nothing is said
constexpr double kOnStep = 0.1;       // steps: from a multiple of the step, by rounding of numbers
constexpr double kSameNumber = 1e-9;  // of the largest reading

// Has any axis gone over so many steps? Of a sensor that lies still they are not told.
bool goes_far(const VectorSeries& s, const Vector3& step) {
  Vector3 low = s.v.front(), high = low;
  for (const Vector3& v : s.v) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return ((high - low).array() > kManySteps * step.array() && step.array() > 0.0).any();
}

double largest(const VectorSeries& s) {
  double out = 0.0;
  for (const Vector3& v : s.v) out = std::max(out, v.cwiseAbs().maxCoeff());
  return out;
}

// The least change of each axis, if all its changes are multiples of it; 0: it never changes.
std::optional<Vector3> steps_of(const VectorSeries& s, double same) {
  Vector3 step = Vector3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    double least = INFINITY;
    for (std::size_t k = 1; k < s.size(); ++k) {
      const double d = std::abs(s.v[k][axis] - s.v[k - 1][axis]);
      if (d > same) least = std::min(least, d);
    }
    if (!std::isfinite(least)) continue;
    for (std::size_t k = 1; k < s.size(); ++k) {
      const double steps = std::abs(s.v[k][axis] - s.v[k - 1][axis]) / least;
      if (std::abs(steps - std::round(steps)) > kOnStep) return std::nullopt;
    }
    step[axis] = least;
  }
  return step;
}

// Of stretches in which an axis changes by a few steps at the most.
struct SlowStretches {
  int changes = 0;  // of all axes
  // Stretches; those without more changes than steps: noise goes to and fro.
  int all = 0, steady = 0;
  // Changes of one axis; of several at once, as of a sensor that is read twice.
  int alone = 0, together = 0;
};

void look_at(const VectorSeries& s, std::size_t begin, const Vector3& step, double same,
             SlowStretches& out) {
  Vector3 low = s.v[begin], high = low;
  Eigen::Vector3i changes = Eigen::Vector3i::Zero();
  int alone = 0, together = 0;
  for (std::size_t k = begin + 1; k < begin + kSlowStretch; ++k) {
    low = low.cwiseMin(s.v[k]);
    high = high.cwiseMax(s.v[k]);
    const Eigen::Vector3i changed =
        ((s.v[k] - s.v[k - 1]).cwiseAbs().array() > same).cast<int>().matrix();
    changes += changed;
    if (changed.sum() > 0) ++(changed.sum() == 1 ? alone : together);
  }
  int slow = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (step[axis] == 0.0 || high[axis] - low[axis] > kFewSteps * step[axis]) continue;
    ++slow;
    out.changes += changes[axis];
    out.steady += changes[axis] <= int(kFewSteps) ? 1 : 0;
  }
  out.all += slow;
  if (slow < 3) return;
  out.alone += alone;
  out.together += together;
}

}  // namespace

std::optional<Vector3> coarse_steps(const VectorSeries& series) {
  if (series.size() < kSlowStretch) return std::nullopt;
  const double same = kSameNumber * largest(series);
  const std::optional<Vector3> step = steps_of(series, same);
  if (!step || !goes_far(series, *step)) return std::nullopt;
  SlowStretches slow;
  for (std::size_t k = 0; k + kSlowStretch <= series.size(); k += kSlowStretch) {
    look_at(series, k, *step, same, slow);
  }
  const bool coarse = slow.changes >= int(kFewestToJudge) && slow.steady > kSteady * slow.all &&
                      slow.alone >= slow.together;
  return coarse ? step : std::nullopt;
}

}  // namespace magimu
