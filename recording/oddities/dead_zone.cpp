// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/dead_zone.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr std::size_t kEnoughZeros = 20;  // readings
constexpr std::size_t kEnoughEdges = 5;   // times that readings become that one, or cease to be
// With a dead zone a rate falls to the edge of the zone before it is in it. So readings beside are
// at most so many times the smallest distance from it. Beside empty rows, or where a sensor hangs,
// they have any size.
constexpr double kAtTheEdge = 2.0;
// Least size of the zone, in steps of the converter: a coarse converter without a zone has one.
constexpr double kSteps = 3.0;
// Changes below this share of large ones (nine of ten are smaller) are rounding of one reading.
constexpr double kRounding = 1e-3, kLarge = 0.9;

// The value that is read most often.
double most_frequent(std::vector<double> x) {
  std::ranges::sort(x);
  std::size_t best = 0, at = 0;
  for (std::size_t k = 0, begin = 0; k < x.size(); ++k) {
    if (x[k] != x[begin]) begin = k;
    if (k - begin > best) {
      best = k - begin;
      at = k;
    }
  }
  return x.empty() ? NAN : x[at];
}

// The converter's step, or less: the smallest change from one reading to the next that is more than
// rounding of the same reading (a file's numbers may differ in their last digits).
double smallest_change(const std::vector<double>& x) {
  std::vector<double> changes;
  for (std::size_t k = 1; k < x.size(); ++k) {
    if (x[k] != x[k - 1]) changes.push_back(std::abs(x[k] - x[k - 1]));
  }
  if (changes.empty()) return INFINITY;
  const double rounding = kRounding * quantile(changes, kLarge);
  double step = INFINITY;
  for (const double change : changes) {
    if (change > rounding) step = std::min(step, change);
  }
  return step;
}

// The smallest of the others where readings fall to 0 from there. `sizes`: distances of an axis, or
// of the whole vector, from the reading within the zone; step: of the converter.
std::optional<double> edge_of(const std::vector<double>& sizes, double step) {
  double least = INFINITY;
  std::size_t zeros = 0;
  std::vector<double> beside;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    const double size = sizes[k], before = k > 0 ? sizes[k - 1] : size;
    zeros += size == 0.0 ? 1 : 0;
    if (size > 0.0) least = std::min(least, size);
    if ((size == 0.0) != (before == 0.0)) beside.push_back(std::max(size, before));
  }
  if (zeros < kEnoughZeros || beside.size() < kEnoughEdges || least < kSteps * step) return {};
  if (!(median(std::move(beside)) < kAtTheEdge * least)) return {};
  return least;
}

}  // namespace

std::optional<DeadZone> dead_zone_of(const VectorSeries& gyr) {
  DeadZone out{Vector3::Constant(NAN), 0.0};
  Vector3 usual;
  double coarsest = 0.0;
  std::vector<Vector3> all;
  std::ranges::copy_if(gyr.v, std::back_inserter(all),
                       [](const Vector3& v) { return v.allFinite(); });
  if (all.empty()) return std::nullopt;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> x, sizes;
    for (const Vector3& v : all) x.push_back(v[axis]);
    usual[axis] = most_frequent(x);
    for (const Vector3& v : all) sizes.push_back(std::abs(v[axis] - usual[axis]));
    const double step = smallest_change(x);
    coarsest = std::max(coarsest, step);
    if (const auto edge = edge_of(sizes, step)) {
      out.reads[axis] = usual[axis];
      out.edge = std::max(out.edge, *edge);
    }
  }
  // One band for the length of the rate: its axes come near to their reading elsewhere, too.
  std::vector<double> lengths;
  for (const Vector3& v : all) lengths.push_back((v - usual).norm());
  if (const auto edge = edge_of(lengths, coarsest)) out = {usual, *edge};
  if (out.reads.array().isNaN().all()) return std::nullopt;
  return out;
}

}  // namespace magimu
