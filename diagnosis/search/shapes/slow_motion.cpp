// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/shapes/slow_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/motion/rests/rests.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kHandsSlowest = 0.5, kHandsFastest[kHandsBands] = {1.0, 1.25, 1.5},
                 kFaster = 2.5;             // Hz
constexpr double kSlower[2] = {0.05, 0.3};  // Hz
constexpr std::size_t kFewestNodes = 8;
constexpr double kCut = 3.0;  // standard deviations
// Standard deviations of the ratio at rest from which the noise counts as coloured; the second
// where the residuals in motion have less slow power than coloured noise. (A rest lasts seconds,
// and a hand begins to move before it ends.)
constexpr double kNotWhite = 2.0, kSurelyNotWhite = 4.0;
constexpr double kLessSlow = 3.0;  // standard deviations of over_slower

// Squares of coefficients, whose mean is sum / weights.
struct Power {
  double sum = 0.0, weights = 0.0, squared_weights = 0.0;

  void add(double square, double weight = 1.0) {
    sum += weight * square;
    weights += weight;
    squared_weights += weight * weight;
  }
  double mean() const { return sum / weights; }
  // Of the logarithm of the mean of white noise.
  double variance() const { return 2.0 * squared_weights / (weights * weights); }
};

// The logarithm of one mean over another, in standard deviations.
double over(const Power& one, const Power& other) {
  if (!(one.sum > 0.0) || !(other.sum > 0.0)) return 0.0;
  return std::log(one.mean() / other.mean()) / std::sqrt(one.variance() + other.variance());
}

// In the band of a hand that moves up to kHandsFastest[b]: each coefficient the same, and weighted
// by what a hand's acceleration has of it.
struct HandsBand {
  Power plain, weighted;
};

struct BandPower {
  std::array<HandsBand, kHandsBands> hands;
  Power fast, slower;

  double log_ratio(std::size_t band) const {
    const Power& slow = hands[band].weighted;
    return slow.sum > 0.0 && fast.sum > 0.0 ? std::log(slow.mean() / fast.mean()) : 0.0;
  }
  double variance(std::size_t band) const {
    return hands[band].weighted.variance() + fast.variance();
  }
};

// One axis of a piece by the orthonormal discrete cosine transform, whose coefficient k has k/2
// periods in the piece. The fast band's power is the total less that of the other coefficients.
void add_power(const std::vector<double>& x, double interval_s, BandPower& out) {
  const auto n = double(x.size());
  double mean = 0.0, total = 0.0;
  for (const double v : x) mean += v / n;
  for (const double v : x) total += (v - mean) * (v - mean);
  double count = n - 1.0;
  const double step_hz = 0.5 / (n * interval_s);
  for (int k = 1; k < int(x.size()) && k * step_hz < kFaster; ++k) {
    const double half = 0.5 * M_PI * k / n, twice = 2.0 * std::cos(2.0 * half);
    double before = std::cos(half), now = before, sum = 0.0;  // cos((i - 1/2) 2 half)
    for (const double v : x) {
      sum += (v - mean) * now;
      const double next = twice * now - before;
      before = now;
      now = next;
    }
    const double power = 2.0 / n * sum * sum;
    total -= power;
    count -= 1.0;
    const double hz = k * step_hz;
    if (hz >= kSlower[0] && hz <= kSlower[1]) out.slower.add(power);
    for (std::size_t band = 0; band < kHandsBands; ++band) {
      if (hz < kHandsSlowest || hz > kHandsFastest[band]) continue;
      out.hands[band].plain.add(power);
      out.hands[band].weighted.add(power, std::pow(hz / kHandsFastest[band], 4));
    }
  }
  out.fast.sum += std::max(0.0, total);
  out.fast.weights += std::max(0.0, count);
  out.fast.squared_weights = out.fast.weights;
}

BandPower power_of(const std::vector<std::vector<Vector3>>& pieces, double interval_s,
                   int first_axis) {
  std::vector<double> sizes;
  for (const auto& piece : pieces) {
    for (const Vector3& r : piece) {
      for (int axis = first_axis; axis < 3; ++axis) sizes.push_back(std::abs(r[axis]));
    }
  }
  BandPower out;
  if (sizes.empty()) return out;
  const double cut = kCut * 1.4826 * median(sizes);
  for (const auto& piece : pieces) {
    if (piece.size() < kFewestNodes) continue;
    for (int axis = first_axis; axis < 3; ++axis) {
      std::vector<double> x;
      for (const Vector3& r : piece) x.push_back(std::clamp(r[axis], -cut, cut));
      add_power(x, interval_s, out);
    }
  }
  return out;
}

}  // namespace

NodeResiduals node_residuals(const Stage& stage, const std::vector<const Recording*>& recordings,
                             Sensor sensor) {
  const Values& values = stage.result().values;
  const LinearSystem system(stage.graph(), values);
  const VectorXd r = system.whitened_residuals(values);
  const SensorRows rows(stage.graph(), system);
  std::size_t nodes = 0;
  for (const NodePlan& plan : stage.plans()) nodes += plan.t.size();
  std::vector<Vector3> of_node(nodes, Vector3::Zero());
  std::vector<int> seen(nodes, 0);
  for (int i = 0; i < system.rows(); ++i) {
    const int node = rows.node[std::size_t(i)];
    if (rows.sensor[std::size_t(i)] != sensor || node < 0 || seen[std::size_t(node)] == 3) continue;
    of_node[std::size_t(node)][seen[std::size_t(node)]++] = r[i];
  }
  NodeResiduals out;
  double seconds = 0.0, intervals = 0.0;
  std::size_t first = 0;
  for (std::size_t p = 0; p < recordings.size(); ++p) {
    const std::vector<double>& t = stage.plans()[p].t;
    const std::vector<TimeSpan> rests = quiet_rests(*recordings[p], find_rests(*recordings[p]));
    const auto rest_at = [&](double time) {
      for (std::size_t s = 0; s < rests.size(); ++s) {
        if (time >= rests[s].begin_s && time <= rests[s].end_s) return int(s);
      }
      return -1;
    };
    int last = -2;
    for (std::size_t k = 0; k < t.size(); ++k) {
      const int rest = rest_at(t[k]);
      auto& pieces = rest < 0 ? out.moving : out.still;
      if (seen[first + k] < 3) {
        last = -2;
        continue;
      }
      if (rest != last) pieces.emplace_back();
      // In n, since in the frame of a sensor that turns the hand's frequencies are shifted.
      pieces.back().push_back(values.at<Rot3>(R(int(first + k))) * of_node[first + k]);
      last = rest;
    }
    first += t.size();
    seconds += t.back() - t.front();
    intervals += double(t.size()) - 1.0;
  }
  out.interval_s = seconds / std::max(1.0, intervals);
  return out;
}

SlowPower slow_power(const NodeResiduals& residuals, Axes axes) {
  const int first_axis = axes == Axes::kVertical ? 2 : 0;
  const BandPower moving = power_of(residuals.moving, residuals.interval_s, first_axis);
  const BandPower still = power_of(residuals.still, residuals.interval_s, first_axis);
  SlowPower best;
  for (std::size_t b = 0; b < kHandsBands; ++b) {
    const HandsBand &hand = moving.hands[b], &rest = still.hands[b];
    if (hand.plain.weights < 1.0 || moving.fast.weights < 1.0) continue;
    if (rest.plain.weights < 1.0 || still.fast.weights < 1.0) continue;
    SlowPower out;
    out.over_rest = over(hand.plain, rest.plain);  // rests are short
    out.over_slower = over(hand.weighted, moving.slower);
    out.log_ratio = moving.log_ratio(b);
    double variance = moving.variance(b);
    const double not_white = out.over_slower > kLessSlow ? kSurelyNotWhite : kNotWhite;
    if (still.log_ratio(b) > not_white * std::sqrt(still.variance(b))) {
      out.log_ratio -= still.log_ratio(b);
      variance += still.variance(b);
    }
    out.sigma = std::sqrt(variance);
    out.unknowns = hand.plain.weights;
    out.squares = std::max(0.0, hand.plain.sum - hand.plain.weights * moving.fast.mean());
    if (best.unknowns == 0.0 || out.z() > best.z()) best = out;
  }
  return best;
}

}  // namespace magimu
