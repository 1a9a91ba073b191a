// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/slow_motion.h"

#include <algorithm>
#include <cmath>

#include "calibration/rests.h"
#include "recording/median.h"

namespace magimu {
namespace {

constexpr double kHandsSlowest = 0.5, kHandsFastest = 1.5, kFaster = 2.5;  // Hz
constexpr double kSlower[2] = {0.05, 0.3};                                 // Hz
constexpr std::size_t kFewestNodes = 8;
constexpr double kCut = 3.0;  // standard deviations
// Standard deviations of the ratio at rest: of noise that may be coloured, and of what is less slow
// in motion than coloured noise is. A rest lasts seconds, and a hand begins to move before it ends.
constexpr double kNotWhite = 2.0, kSurelyNotWhite = 4.0;
constexpr double kLessSlow = 3.0;  // standard deviations of over_slower

struct BandPower {
  double slow = 0.0, slow_count = 0.0;
  double fast = 0.0, fast_count = 0.0;
  double slower = 0.0, slower_count = 0.0;

  double log_ratio() const {
    return slow > 0.0 && fast > 0.0 ? std::log(slow / slow_count * fast_count / fast) : 0.0;
  }
  double variance() const { return 2.0 / slow_count + 2.0 / fast_count; }
};

// One axis of a piece: the orthonormal discrete cosine transform, of which coefficient k turns k/2
// times a piece. What is fast is the rest of all.
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
    if (hz >= kSlower[0] && hz <= kSlower[1]) {
      out.slower += power;
      out.slower_count += 1.0;
    } else if (hz >= kHandsSlowest && hz <= kHandsFastest) {
      out.slow += power;
      out.slow_count += 1.0;
    }
  }
  out.fast += std::max(0.0, total);
  out.fast_count += std::max(0.0, count);
}

BandPower power_of(const std::vector<std::vector<Vector3>>& pieces, double interval_s) {
  std::vector<double> sizes;
  for (const auto& piece : pieces) {
    for (const Vector3& r : piece) {
      for (const double x : r) sizes.push_back(std::abs(x));
    }
  }
  BandPower out;
  if (sizes.empty()) return out;
  const double cut = kCut * 1.4826 * median(sizes);
  for (const auto& piece : pieces) {
    if (piece.size() < kFewestNodes) continue;
    for (int axis = 0; axis < 3; ++axis) {
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
    const std::vector<TimeSpan> rests = find_rests(*recordings[p]);
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
      pieces.back().push_back(of_node[first + k]);
      last = rest;
    }
    first += t.size();
    seconds += t.back() - t.front();
    intervals += double(t.size()) - 1.0;
  }
  out.interval_s = seconds / std::max(1.0, intervals);
  return out;
}

SlowPower slow_power(const NodeResiduals& residuals) {
  SlowPower out;
  const BandPower moving = power_of(residuals.moving, residuals.interval_s);
  if (moving.slow_count < 1.0 || moving.fast_count < 1.0) return out;
  const BandPower still = power_of(residuals.still, residuals.interval_s);
  if (still.slow_count < 1.0 || still.fast_count < 1.0) return out;
  const auto over = [&](double power, double count) {
    if (!(moving.slow > 0.0) || !(power > 0.0)) return 0.0;
    return std::log(moving.slow / moving.slow_count * count / power) /
           std::sqrt(2.0 / moving.slow_count + 2.0 / count);
  };
  out.over_rest = over(still.slow, still.slow_count);
  out.over_slower = over(moving.slower, moving.slower_count);
  out.log_ratio = moving.log_ratio();
  double variance = moving.variance();
  const double not_white = out.over_slower > kLessSlow ? kSurelyNotWhite : kNotWhite;
  if (still.log_ratio() > not_white * std::sqrt(still.variance())) {
    out.log_ratio -= still.log_ratio();
    variance += still.variance();
  }
  out.sigma = std::sqrt(variance);
  out.unknowns = moving.slow_count;
  out.squares = moving.slow * (1.0 - std::exp(-std::max(0.0, out.log_ratio)));
  return out;
}

}  // namespace magimu
