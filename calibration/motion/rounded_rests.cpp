// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/rounded_rests.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calibration/motion/integrated_rotation.h"
#include "calibration/motion/rests/rests.h"
#include "recording/checks/repeats.h"

namespace magimu {
namespace {

// Steps of the converter. The rounding errors of two readings that far apart are uncorrelated
// (their correlation is the cosine of 2 pi times this).
constexpr double kSamePlace = 0.25;
constexpr double kNearlyAll = 0.9;  // from this share of independent readings on all nodes stay

// Standard deviation about their own mean of rounded readings of a resting sensor.
double scatter_of(double step, double sigma) {
  return std::sqrt(
      std::max(0.0, sigma * sigma + step * step / 12.0 - rounded_mean_variance(step, sigma)));
}

// Size of the field that the sensor turns in, uT: the largest of its axes' half ranges. Smaller
// than the field where the sensor has not turned far.
double strength_of(const VectorSeries& mag) {
  Vector3 low = mag.v.front(), high = low;
  for (const Vector3& v : mag.v) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return 0.5 * (high - low).maxCoeff();
}

// Nodes [begin, end) have this many independent readings together. So many of them, evenly spaced,
// keep their magnetometer; the others get the share 0.
void share_out(std::vector<double>& share, std::size_t begin, std::size_t end, double samples,
               double readings) {
  const std::size_t n = end - begin;
  const auto kept = std::min(n, std::size_t(std::ceil(readings - 1e-9)));
  const double each = std::min(1.0, readings / double(kept) / (samples / double(n)));
  for (std::size_t i = 0; i < n; ++i) {
    // The node in the middle of each of `kept` equal parts.
    const std::size_t part = i * kept / n;
    const std::size_t first = (part * n + kept - 1) / kept;
    const std::size_t last = ((part + 1) * n + kept - 1) / kept;
    share[begin + i] = i == (first + last - 1) / 2 ? each : 0.0;
  }
}

// Writes the shares of one magnetometer's nodes. of_node: samples of a node. False: all shares stay
// 1.
bool share_of_places(const VectorSeries& mag, double step, double sigma, double of_node,
                     const IntegratedRotation& gyr, const std::vector<double>& nodes,
                     std::vector<double>& share) {
  const double same = kSamePlace * step / strength_of(mag);  // rad
  bool any = false;
  for (std::size_t begin = 0; begin < nodes.size();) {
    std::size_t end = begin + 1;
    while (end < nodes.size() && gyr.between(nodes[begin], nodes[end]).Log().norm() < same) ++end;
    if (end - begin > 1) {
      const double samples = of_node * double(end - begin);
      const double readings = independent_readings(step, sigma, samples);
      if (readings < kNearlyAll * samples) {
        share_out(share, begin, end, samples, readings);
        any = true;
      }
    }
    begin = end;
  }
  return any;
}

}  // namespace

double rounded_mean_variance(double step, double sigma) {
  if (!(step > 0.0)) return 0.0;
  // At sigma = 0 the terms fall as 1 / m^2: the rest of the sum is 0.3 %.
  constexpr int kTerms = 200;
  double sum = 0.0;
  for (int m = 1; m <= kTerms; ++m) {
    const double damped = std::exp(-std::pow(2.0 * M_PI * m * sigma / step, 2));
    sum += 0.5 * std::pow(step / (M_PI * m), 2) * damped;
    if (damped < 1e-12) break;
  }
  return sum;
}

double sigma_before_rounding(double step, double scatter) {
  double low = 0.0, high = scatter + step;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (scatter_of(step, middle) < scatter ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double independent_readings(double step, double sigma, double samples) {
  const double all = sigma * sigma + step * step / 12.0;
  const double fixed = std::min(all, rounded_mean_variance(step, sigma));
  return all > 0.0 ? all / (fixed + (all - fixed) / samples) : samples;
}

std::vector<std::vector<double>> independent_shares(const Recording& recording,
                                                    const std::vector<double>& nodes) {
  const std::vector<TimeSpan> rests = find_rests(recording);
  if (rests.empty() || nodes.size() < 2) return {};
  const std::vector<double> density = mag_noise_at_rest(recording, rests);
  std::optional<IntegratedRotation> gyr;  // integrated once, for the first sensor that needs it
  std::vector<std::vector<double>> out(recording.mag.size(), std::vector(nodes.size(), 1.0));
  bool any = false;
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    const VectorSeries& mag = recording.mag[m];
    const Vector3 steps = least_steps(mag);
    const double rate = mag.rate_hz();
    if (!steps.allFinite() || !(rate > 0.0)) continue;
    const double step = std::sqrt(steps.squaredNorm() / 3.0);
    const double sigma = sigma_before_rounding(step, density[m] * std::sqrt(rate));
    const double of_node =
        std::max(1.0, rate * (nodes.back() - nodes.front()) / double(nodes.size() - 1));
    // The more samples a place has, the smaller a share of them is independent.
    const double all = of_node * double(nodes.size());
    if (independent_readings(step, sigma, all) >= kNearlyAll * all) continue;
    if (!gyr) {
      gyr.emplace(recording.gyr, gyr_bias_at_rest(recording, rests).value_or(Vector3::Zero()));
    }
    any = share_of_places(mag, step, sigma, of_node, *gyr, nodes, out[m]) || any;
  }
  return any ? out : std::vector<std::vector<double>>{};
}

}  // namespace magimu
