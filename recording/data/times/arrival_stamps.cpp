// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/times/arrival_stamps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "statistics/quantiles.h"

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
// However late each comes, at a steady pace that does not add up. Distances without any pace do: of
// n of them a line leaves sqrt(n / 15) of their standard deviation. As small a share as this never
// happens by chance.
constexpr double kAddsUp = 0.1;
constexpr double kHardlyLonger = 0.99;  // quantile of their distances: what is far longer is a gap

// Loop gains of EvenPace, of the departure at a burst's end: phase, and period for critical
// damping. Ten bursts' memory: the scatter of their stamps averages out, and a clock's drift does
// not matter.
constexpr double kPhaseGain = 0.1, kPeriodGain = kPhaseGain * kPhaseGain / 4.0;

// Interval up to which a sample belongs to the burst of the one before, s; 0: unknown.
double brief_interval(const std::vector<double>& t) {
  double sum = 0.0;
  std::size_t counted = 0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double d = t[i] - t[i - 1];
    if (d > kLongestBurst) continue;
    sum += d;
    ++counted;
  }
  return counted == 0 || !(sum > 0.0) ? 0.0 : kWithin * sum / double(counted);
}

// Samples first <= i < end between two gaps, and their bursts' last samples.
struct Stretch {
  std::size_t first, end;
  std::vector<std::size_t> last;
};

// By how much bursts of such distances would depart from a line if each distance had nothing to do
// with the others, root mean square.
double left_without_pace(const std::vector<double>& distances) {
  constexpr double kOfAWalk = 15.0;
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const double d : distances) {
    if (d > kLongestBurst) continue;
    n += 1.0;
    sum += d;
    squares += d * d;
  }
  if (n < 2.0) return 0.0;
  return std::sqrt(std::max(0.0, squares / n - sum / n * (sum / n)) * n / kOfAWalk);
}

// A line through the bursts' ends of each stretch between gaps, all of one slope.
struct Lines {
  EvenTimes even;
  double off_s = 0.0;  // by which the ends depart from them, root mean square
};
std::optional<Lines> lines_through(const std::vector<double>& t, double brief, double gap_s) {
  std::vector<Stretch> stretches{{0, 0, {}}};
  for (std::size_t i = 0; i < t.size(); ++i) {
    const bool ends = i + 1 == t.size() || t[i + 1] - t[i] >= brief;
    if (ends) stretches.back().last.push_back(i);
    stretches.back().end = i + 1;
    if (i + 1 < t.size() && t[i + 1] - t[i] > gap_s) {
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
  Lines out;
  double off = 0.0;
  out.even.t.reserve(t.size());
  for (const Stretch& s : stretches) {
    const double i0 = mean_of(s, index), t0 = mean_of(s, time);
    for (const std::size_t i : s.last) off += std::pow(t0 + (double(i) - i0) * h - t[i], 2);
    double begin = t0 + (double(s.first) - i0) * h;
    if (!out.even.t.empty()) begin = std::max(begin, out.even.t.back() + h);
    for (std::size_t i = s.first; i < s.end; ++i) {
      out.even.t.push_back(begin + double(i - s.first) * h);
    }
  }
  out.even.gap_s = gap_s;
  out.even.rate_hz = 1.0 / h;
  out.even.in_a_burst = double(t.size()) / bursts;
  out.off_s = std::sqrt(off / bursts);
  return out;
}

}  // namespace

std::optional<EvenTimes> even_times(const std::vector<double>& t) {
  if (t.size() < 4 * kEnoughBursts) return std::nullopt;
  const double brief = brief_interval(t);
  if (brief == 0.0) return std::nullopt;
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
  const double usual = median(std::vector<double>(distances));
  std::optional<Lines> lines = lines_through(t, brief, kLost * usual);
  if (lines && lines->off_s > kUnsteady * usual) {
    // Does each come as late as it likes? A long distance is no gap then.
    const double adds_up = kAddsUp * left_without_pace(distances);
    lines = lines_through(t, brief, kLost * quantile(std::move(distances), kHardlyLonger));
    if (lines && lines->off_s > adds_up) return std::nullopt;
  }
  if (!lines) return std::nullopt;
  lines->even.burst_s = usual;
  return std::move(lines->even);
}

std::string rate_text(double rate_hz) {
  constexpr double kKnown = 0.005;
  const double whole = std::round(rate_hz);
  return fmt::format("{:.4g}", std::abs(whole - rate_hz) < kKnown * rate_hz ? whole : rate_hz);
}

bool may_be_bursts(const std::vector<double>& t) {
  const double brief = brief_interval(t);
  std::size_t together = 0;
  for (std::size_t i = 1; i < t.size(); ++i) together += t[i] - t[i - 1] < brief ? 1 : 0;
  return brief > 0.0 && double(together) >= kShort * double(t.size() - 1);
}

void BriefIntervals::add(double interval_s) {
  if (interval_s > kLongestBurst) return;
  sum_ += interval_s;
  ++added_;
}

void BriefIntervals::count(double interval_s) {
  ++counted_;
  together_ += interval_s * double(added_) < kWithin * sum_ ? 1 : 0;
}

bool BriefIntervals::may_be_bursts() const {
  return counted_ + 1 >= 4 * kEnoughBursts && sum_ > 0.0 &&
         double(together_) >= kShort * double(counted_);
}

std::size_t in_whole_bursts(const std::vector<double>& t) {
  const double brief = brief_interval(t);
  std::size_t n = t.size();
  while (n > 1 && t[n - 1] - t[n - 2] < brief) --n;
  return n > 0 ? n - 1 : 0;
}

EvenPace::EvenPace(const EvenTimes& found, const std::vector<double>& stamps)
    : period_(1.0 / found.rate_hz),
      burst_s_(found.burst_s),
      brief_(brief_interval(stamps)),
      tolerance_(found.gap_s),
      time_(found.t.back()),
      stamp_(stamps.back()) {}

double EvenPace::next(double t) {
  const double interval = t - stamp_;
  if (interval >= brief_ && interval <= tolerance_) {
    // The one before was the last of its burst.
    const double off = std::clamp(stamp_ - time_, -burst_s_, burst_s_);
    time_ += kPhaseGain * std::clamp(off, -period_, period_);
    period_ += kPeriodGain * off * period_ / burst_s_;
  }
  const bool jumped = interval > tolerance_ || interval < 0.0;  // a gap, or a clock that was set
  time_ = jumped ? t : time_ + period_;
  stamp_ = t;
  return time_;
}

}  // namespace magimu
