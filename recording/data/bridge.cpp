// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/bridge.h"

#include <algorithm>
#include <cmath>

#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kOffBeat = 0.25;  // of the usual interval: a clock is steady where few differ so
constexpr std::size_t kForClock = 10;    // samples; of fewer no clock is known
constexpr std::size_t kFewOffBeat = 10;  // one in so many

struct Clock {
  double usual_s = 0.0;
  bool steady = false;
};

Clock clock_of(const std::vector<double>& t) {
  std::vector<double> dt;
  for (std::size_t k = 1; k < t.size(); ++k) dt.push_back(t[k] - t[k - 1]);
  Clock out{median(dt), false};
  const auto off = std::ranges::count_if(
      dt, [&](double d) { return std::abs(d - out.usual_s) > kOffBeat * out.usual_s; });
  out.steady = std::size_t(off) * kFewOffBeat < dt.size();
  return out;
}

// Times at which samples are missing between a and b.
std::vector<double> missing(double a, double b, const Clock& clock) {
  std::vector<double> out;
  const double beats = (b - a) / clock.usual_s;
  const int n = int(std::lround(std::min(beats, kLongestHole + 2.0)));
  if (!clock.steady || n < 2 || std::abs(beats - n) > kOffBeat) return out;
  for (int i = 1; i < n; ++i) out.push_back(a + (b - a) * double(i) / double(n));
  return out;
}

// The cubic through the samples k - 1 to k + 2.
Vector3 cubic(const VectorSeries& s, std::size_t k, double t) {
  Vector3 out = Vector3::Zero();
  for (std::size_t i = k - 1; i <= k + 2; ++i) {
    double weight = 1.0;
    for (std::size_t j = k - 1; j <= k + 2; ++j) {
      if (j != i) weight *= (t - s.t[j]) / (s.t[i] - s.t[j]);
    }
    out += weight * s.v[i];
  }
  return out;
}

}  // namespace

VectorSeries bridged(const VectorSeries& series, const std::vector<double>& taken_out) {
  if (series.size() < kForClock) return series;
  const Clock clock = clock_of(series.t);
  const double near = (kLongestHole + 2) * clock.usual_s;
  VectorSeries out;
  auto taken = taken_out.begin();
  for (std::size_t k = 0; k < series.size(); ++k) {
    out.push_back(series.t[k], series.v[k]);
    if (k + 1 == series.size()) break;
    std::vector<double> times;
    while (taken != taken_out.end() && *taken < series.t[k + 1]) {
      if (*taken > series.t[k]) times.push_back(*taken);
      ++taken;
    }
    if (times.empty()) times = missing(series.t[k], series.t[k + 1], clock);
    const bool inside =
        k > 0 && k + 2 < series.size() && series.t[k + 2] - series.t[k - 1] < 2.0 * near;
    if (!inside || times.size() > std::size_t(kLongestHole)) continue;
    for (const double t : times) out.push_back(t, cubic(series, k, t));
  }
  return out;
}

}  // namespace magimu
