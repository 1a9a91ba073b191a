// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/dead_zone.h"

#include <algorithm>
#include <cmath>

#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr std::size_t kEnoughZeros = 20;  // readings
constexpr std::size_t kEnoughEdges = 5;   // times that readings become 0, or cease to be
// With a dead zone a rate falls to the edge of the zone before it is 0. So readings beside zeros
// are at most so many times the smallest readings that are not 0. Beside empty rows they have any
// size.
constexpr double kAtTheEdge = 2.0;
// Least size of the zone, in steps of the converter: a coarse converter without a zone has one.
constexpr double kSteps = 3.0;

// `sizes`: absolute readings of an axis, or lengths of the whole vector.
bool falls_to_zero(const std::vector<double>& sizes) {
  double least = INFINITY, step = INFINITY;
  std::size_t zeros = 0;
  std::vector<double> beside;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    const double size = sizes[k], before = k > 0 ? sizes[k - 1] : size;
    zeros += size == 0.0 ? 1 : 0;
    if (size > 0.0) least = std::min(least, size);
    if (size > 0.0 && before > 0.0 && size != before) {
      step = std::min(step, std::abs(size - before));
    }
    if ((size == 0.0) != (before == 0.0)) beside.push_back(std::max(size, before));
  }
  if (zeros < kEnoughZeros || beside.size() < kEnoughEdges || least < kSteps * step) return false;
  return median(std::move(beside)) < kAtTheEdge * least;
}

}  // namespace

bool zeroes_small_rates(const VectorSeries& gyr) {
  std::vector<double> lengths;
  for (const Vector3& v : gyr.v) lengths.push_back(v.norm());
  if (falls_to_zero(lengths)) return true;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> sizes;
    for (const Vector3& v : gyr.v) sizes.push_back(std::abs(v[axis]));
    if (falls_to_zero(sizes)) return true;
  }
  return false;
}

}  // namespace magimu
