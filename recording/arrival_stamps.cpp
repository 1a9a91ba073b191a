// SPDX-License-Identifier: BSD-3-Clause
#include "recording/arrival_stamps.h"

#include <algorithm>
#include <cmath>

#include "recording/median.h"

namespace magimu {
namespace {

// A burst's samples follow each other within this share of the mean interval.
constexpr double kWithin = 0.25;
// Share of intervals that are so short: half with two at a time, more with more. Of samples that
// come independently of each other, a process without any pace, exp(-1/4) = 78 % are longer.
constexpr double kShort = 0.4;
constexpr double kLongestBurst = 2.0;  // s from burst to burst: longer ones are gaps
constexpr double kLost = 2.5;          // usual distances of bursts: one is lost in between
constexpr std::size_t kEnoughBursts = 10;
// Distances of bursts by which they may come early or late, root mean square: else their samples
// were not measured at a steady pace.
constexpr double kUnsteady = 0.5;

// Samples first <= i < end between two gaps, and their bursts' last samples.
struct Stretch {
  std::size_t first, end;
  std::vector<std::size_t> last;
};

}  // namespace

std::optional<EvenTimes> even_times(const std::vector<double>& t) {
  if (t.size() < 4 * kEnoughBursts) return std::nullopt;
  double sum = 0.0;
  std::size_t counted = 0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double d = t[i] - t[i - 1];
    if (d > kLongestBurst) continue;
    sum += d;
    ++counted;
  }
  if (counted == 0 || !(sum > 0.0)) return std::nullopt;
  const double brief = kWithin * sum / double(counted);
  std::size_t together = 0;
  std::vector<double> begins;
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (t[i] - t[i - 1] < brief) {
      ++together;
    } else {
      begins.push_back(t[i]);
    }
  }
  if (double(together) < kShort * double(t.size() - 1) || begins.size() < kEnoughBursts) {
    return std::nullopt;
  }
  std::vector<double> distances;
  for (std::size_t b = 1; b < begins.size(); ++b) distances.push_back(begins[b] - begins[b - 1]);
  EvenTimes out;
  out.burst_s = median(std::move(distances));

  std::vector<Stretch> stretches{{0, 0, {}}};
  for (std::size_t i = 0; i < t.size(); ++i) {
    const bool ends = i + 1 == t.size() || t[i + 1] - t[i] >= brief;
    if (ends) stretches.back().last.push_back(i);
    stretches.back().end = i + 1;
    if (i + 1 < t.size() && t[i + 1] - t[i] > kLost * out.burst_s) {
      stretches.push_back({i + 1, i + 1, {}});
    }
  }
  // One interval for all, from lines through the bursts' ends.
  double products = 0.0, squares = 0.0, bursts = 0.0;
  const auto mean_of = [&](const Stretch& s, const auto& value) {
    double mean = 0.0;
    for (const std::size_t i : s.last) mean += value(i) / double(s.last.size());
    return mean;
  };
  const auto index = [](std::size_t i) { return double(i); };
  const auto time = [&t](std::size_t i) { return t[i]; };
  for (const Stretch& s : stretches) {
    const double i0 = mean_of(s, index), t0 = mean_of(s, time);
    for (const std::size_t i : s.last) {
      products += (double(i) - i0) * (t[i] - t0);
      squares += (double(i) - i0) * (double(i) - i0);
    }
    bursts += double(s.last.size());
  }
  const double h = products / std::max(squares, 1e-30);
  if (!(h > 0.0)) return std::nullopt;
  double off = 0.0;
  out.t.reserve(t.size());
  for (const Stretch& s : stretches) {
    const double i0 = mean_of(s, index), t0 = mean_of(s, time);
    for (const std::size_t i : s.last) off += std::pow(t0 + (double(i) - i0) * h - t[i], 2);
    double begin = t0 + (double(s.first) - i0) * h;
    if (!out.t.empty()) begin = std::max(begin, out.t.back() + h);
    for (std::size_t i = s.first; i < s.end; ++i) {
      out.t.push_back(begin + double(i - s.first) * h);
    }
  }
  if (std::sqrt(off / bursts) > kUnsteady * out.burst_s) return std::nullopt;
  out.rate_hz = 1.0 / h;
  out.in_a_burst = double(t.size()) / bursts;
  return out;
}

}  // namespace magimu
