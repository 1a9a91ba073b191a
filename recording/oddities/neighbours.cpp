// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/neighbours.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "recording/oddities/local_course.h"

namespace magimu {
namespace {

constexpr double kSideGap = 4.0;  // times the shortest step: a reading beyond it is no neighbour

// Readings around some others.
struct Around {
  std::array<const Vector3*, kMostNeighbours> v{};
  std::array<double, kMostNeighbours> t{};
  std::size_t n = 0;
  double usual_s = 0.0;  // from one to the next

  // False: it lies beyond a gap.
  bool add(const Vector3& reading, double at, double from, double now) {
    if (std::abs(at - from) > kSideGap * usual_s) return false;
    v[n] = &reading;
    t[n++] = at - now;
    return true;
  }
  // Of each of them against the two beside it.
  Vector3 largest_bend(std::size_t first) const {
    Vector3 out = Vector3::Zero();
    for (std::size_t i = first + 1; i + 1 < n; ++i) {
      out = out.cwiseMax((*v[i] - 0.5 * (*v[i - 1] + *v[i + 1])).cwiseAbs());
    }
    return out;
  }
};

}  // namespace

Neighbours neighbours_of(const ReadingsAround& readings, std::size_t run) {
  const RepeatedReadings &kept = readings.kept, &units = readings.waiting;
  const std::size_t before = std::min(kSide, kept.size());
  const std::size_t after = std::min(kSide, units.size() - run);
  const double now = 0.5 * (units.front().begin_s + units[run - 1].begin_s);
  Around around;
  around.usual_s = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < before; ++i) {
    around.usual_s =
        std::min(around.usual_s, kept[kept.size() - i].begin_s - kept[kept.size() - i - 1].begin_s);
  }
  for (std::size_t i = 1; i < after; ++i) {
    around.usual_s = std::min(around.usual_s, units[run + i].begin_s - units[run + i - 1].begin_s);
  }
  Neighbours out{Vector3::Zero(), Vector3::Constant(std::numeric_limits<double>::infinity()),
                 Vector3::Zero(), false, false};
  double from = units.front().begin_s;
  for (std::size_t i = 0; i < before; ++i) {
    const RepeatedReading& unit = kept[kept.size() - 1 - i];
    if (!around.add(unit.v, unit.begin_s, from, now)) break;
    out.before = i > 0;
    from = unit.begin_s;
  }
  out.bend = around.largest_bend(0);
  const std::size_t n_before = around.n;
  from = units[run - 1].begin_s;
  for (std::size_t i = 0; i < after; ++i) {
    const RepeatedReading& unit = units[run + i];
    if (!around.add(unit.v, unit.begin_s, from, now)) break;
    out.after = i > 0;
    from = unit.begin_s;
  }
  out.bend = out.bend.cwiseMax(around.largest_bend(n_before));
  if (around.n < kSide) return out;
  if (out.both()) {
    const LocalCourse course =
        local_course({around.t.data(), around.n}, {around.v.data(), around.n});
    out.middle = course.middle;
    out.spread = course.spread;
    return out;
  }
  for (int axis = 0; axis < 3; ++axis) {
    std::array<double, kMostNeighbours> x{};
    for (std::size_t i = 0; i < around.n; ++i) x[i] = (*around.v[i])[axis];
    std::sort(x.begin(), x.begin() + std::ptrdiff_t(around.n));
    out.middle[axis] = 0.5 * (x[(around.n - 1) / 2] + x[around.n / 2]);
    out.spread[axis] = std::min(x[around.n - 1] - x[1], x[around.n - 2] - x[0]);
  }
  return out;
}

}  // namespace magimu
