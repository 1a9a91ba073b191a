// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/dead_zone.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
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

// The value that is read most often, and the smallest of several such values; NAN where none is
// read often enough for a dead zone. A first pass counts values by their hash. Only values whose
// counter is high enough are sorted, which are few in an hour of a fine converter.
double most_frequent(const std::vector<double>& x) {
  const int bits = 22;
  std::vector<std::uint8_t> count(std::size_t(1) << bits, 0);
  const auto counter = [](double value) {  // 0.0 makes one value of both zeros
    return std::size_t((std::bit_cast<std::uint64_t>(value + 0.0) * 0x9e3779b97f4a7c15u) >>
                       (64 - bits));
  };
  for (const double value : x) {
    std::uint8_t& own = count[counter(value)];
    if (own < kEnoughZeros) ++own;
  }
  std::vector<double> candidates;
  for (const double value : x) {
    if (count[counter(value)] >= kEnoughZeros) candidates.push_back(value);
  }
  std::ranges::sort(candidates);
  std::size_t best = kEnoughZeros - 1;
  double out = NAN;
  for (std::size_t k = 0, begin = 0; k < candidates.size(); ++k) {
    if (candidates[k] != candidates[begin]) begin = k;
    if (k + 1 - begin > best) {
      best = k + 1 - begin;
      out = candidates[k];
    }
  }
  return out;
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

// The edge of the dead zone: the smallest size other than 0, where readings beside zeros are about
// as small. `sizes`: distances of an axis, or of the whole vector, from the reading within the
// zone; step(): of the converter, called only where it is needed.
template <class Step>
std::optional<double> edge_of(const std::vector<double>& sizes, const Step& step) {
  double least = INFINITY;
  std::size_t zeros = 0;
  std::vector<double> beside;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    const double size = sizes[k], before = k > 0 ? sizes[k - 1] : size;
    zeros += size == 0.0 ? 1 : 0;
    if (size > 0.0) least = std::min(least, size);
    if ((size == 0.0) != (before == 0.0)) beside.push_back(std::max(size, before));
  }
  if (zeros < kEnoughZeros || beside.size() < kEnoughEdges || least < kSteps * step()) return {};
  if (!(median(std::move(beside)) < kAtTheEdge * least)) return {};
  return least;
}

}  // namespace

std::optional<DeadZone> dead_zone_of(const VectorSeries& gyr) {
  DeadZone out{Vector3::Constant(NAN), 0.0};
  Vector3 usual;
  std::vector<Vector3> all;
  std::ranges::copy_if(gyr.v, std::back_inserter(all),
                       [](const Vector3& v) { return v.allFinite(); });
  if (all.empty()) return std::nullopt;
  const auto readings = [&](int axis) {
    std::vector<double> x;
    x.reserve(all.size());
    for (const Vector3& v : all) x.push_back(v[axis]);
    return x;
  };
  const auto step_of = [&](int axis) { return smallest_change(readings(axis)); };
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> sizes = readings(axis);
    usual[axis] = most_frequent(sizes);
    if (std::isnan(usual[axis])) continue;
    for (double& x : sizes) x = std::abs(x - usual[axis]);
    if (const auto edge = edge_of(sizes, [&] { return step_of(axis); })) {
      out.reads[axis] = usual[axis];
      out.edge = std::max(out.edge, *edge);
    }
  }
  // One band for the length of the rate: its axes come near to their reading elsewhere, too.
  if (usual.allFinite()) {
    std::vector<double> lengths;
    lengths.reserve(all.size());
    for (const Vector3& v : all) lengths.push_back((v - usual).norm());
    const auto coarsest = [&] { return std::max({step_of(0), step_of(1), step_of(2)}); };
    if (const auto edge = edge_of(lengths, coarsest)) out = {usual, *edge};
  }
  if (out.reads.array().isNaN().all()) return std::nullopt;
  return out;
}

}  // namespace magimu
