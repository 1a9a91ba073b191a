// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/times/rounded_times.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace magimu {
namespace {

constexpr std::size_t kEnoughStamps = 100;  // samples
// Sampling intervals: shorter steps are rounding that the noise of other things hides.
constexpr double kCoarseStep = 0.25;
constexpr double kWholeSteps = 0.01;  // of a step: a file's decimals are closer
// Steps that an interval may have more than the shortest one: rounding makes two neighbouring
// numbers of steps, and what has many more is jitter or a pause.
constexpr double kStampPause = 4.5;  // mean intervals
constexpr double kHardlyTwos =
    0.1;  // of intervals of one step: twos between them may be lost samples
// Intervals of the rarer length in a row that one clock explains.
constexpr double kOddInARow = 10.0;
constexpr double kAsMany = 0.5;       // of two numbers that are equal but for the ends
constexpr double kOfChance = 0.3;     // of so many pairs of lost samples as chance makes
constexpr double kStampSlack = 1.02;  // of a step: stamps' own rounding

// Samples first <= i < end.
struct Run {
  std::size_t first, end;
};

// The shortest interval, where all others are whole numbers of it; 0 if they are not.
double step_of_stamps(const std::vector<double>& t) {
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double d = t[i] - t[i - 1];
    if (d > 1e-9) step = std::min(step, d);
  }
  if (!std::isfinite(step)) return 0.0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double steps = (t[i] - t[i - 1]) / step;
    if (steps < kStampPause && std::abs(steps - std::round(steps)) > kWholeSteps) return 0.0;
  }
  return step;
}

std::vector<Run> without_pauses(const std::vector<double>& t, double longest) {
  std::vector<Run> runs{{0, 0}};
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (i > 0 && t[i] - t[i - 1] > longest) runs.push_back({i, i});
    runs.back().end = i + 1;
  }
  return runs;
}

// One interval for all: the slope of lines through the stamps of each run.
double common_interval(const std::vector<double>& t, const std::vector<Run>& runs) {
  double products = 0.0, squares = 0.0;
  for (const Run& run : runs) {
    const auto n = double(run.end - run.first);
    double mean = 0.0;
    for (std::size_t i = run.first; i < run.end; ++i) mean += t[i] / n;
    for (std::size_t i = run.first; i < run.end; ++i) {
      const double k = double(i - run.first) - 0.5 * (n - 1.0);
      products += k * (t[i] - mean);
      squares += k * k;
    }
  }
  return squares > 0.0 ? products / squares : 0.0;
}

// Runs whose stamps lie within a span of this length about begin + k h, and the middle of where
// begin may be then.
void split(const std::vector<double>& t, double h, double span, std::vector<Run>& runs,
           std::vector<double>& begins) {
  std::vector<Run> out;
  begins.clear();
  for (const Run& run : runs) {
    std::size_t first = run.first;
    double low = -INFINITY, high = INFINITY;
    for (std::size_t i = run.first; i < run.end; ++i) {
      const double begin = t[i] - double(i - first) * h;
      const double l = std::max(low, begin - 0.5 * kStampSlack * span);
      const double u = std::min(high, begin + 0.5 * kStampSlack * span);
      if (l <= u) {
        low = l;
        high = u;
        continue;
      }
      out.push_back({first, i});
      begins.push_back(0.5 * (low + high));
      first = i;
      low = t[i] - 0.5 * kStampSlack * span;
      high = t[i] + 0.5 * kStampSlack * span;
    }
    out.push_back({first, run.end});
    begins.push_back(0.5 * (low + high));
  }
  runs = std::move(out);
}

}  // namespace

std::optional<RoundedTimes> rounded_times(const std::vector<double>& t) {
  if (t.size() < kEnoughStamps) return std::nullopt;
  RoundedTimes out;
  out.step_s = step_of_stamps(t);
  if (out.step_s == 0.0) return std::nullopt;
  // Without pauses, which one long interval more or less does not change.
  double sum = 0.0, count = 0.0;
  const double usual = (t.back() - t.front()) / double(t.size() - 1);
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double d = t[i] - t[i - 1];
    if (d > kStampPause * std::max(usual, out.step_s)) continue;
    sum += d;
    count += 1.0;
  }
  if (!(sum > 0.0)) return std::nullopt;
  const double mean = sum / count;
  out.rate_hz = 1.0 / mean;
  if (out.step_s < kCoarseStep * mean) return std::nullopt;

  // Two neighbouring lengths, the commoner one first.
  const double low = std::floor(mean / out.step_s + kWholeSteps);
  double shorter = 0.0, longer = 0.0, less = 0.0, longest = 0.0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double steps = std::round((t[i] - t[i - 1]) / out.step_s);
    less += steps < low ? 1.0 : 0.0;
    shorter += steps == low ? 1.0 : 0.0;
    longer += steps == low + 1.0 ? 1.0 : 0.0;
    longest += steps == low + 2.0 ? 1.0 : 0.0;
  }
  const double rarer = std::min(shorter, longer);
  if (rarer < kOddInARow) return std::nullopt;  // even as they are
  // Where one step is the rule, two of them may be a sample that was lost, unless as many samples
  // share a time.
  if (low == 1.0 && longer < kHardlyTwos * shorter && less < kAsMany * longer) return std::nullopt;

  // Rounding alone makes none that are shorter. Samples that come a little unevenly do; where two
  // of them have one time, times that a steady clock has within a step are the better ones.
  const bool uneven = less * kOddInARow > rarer, share_times = low == 0.0 || less > 0.0;
  if (uneven && low > 1.0) return out;
  const std::vector<Run> whole = without_pauses(t, kStampPause * std::max(mean, out.step_s));
  std::vector<Run> runs;
  std::vector<double> begins;
  double h = 0.0;
  const auto is_even_within = [&](double within_s) {
    out.within_s = within_s;
    h = common_interval(t, whole);
    for (int pass = 0; pass < 2; ++pass) {
      runs = whole;
      split(t, h, 2.0 * within_s, runs, begins);
      if (pass == 0) h = common_interval(t, runs);
    }
    return h > 0.0 && double(runs.size() - whole.size()) * kOddInARow <= rarer;
  };
  const bool even = (!uneven && is_even_within(0.5 * out.step_s)) ||
                    (low <= 1.0 && share_times && is_even_within(out.step_s));
  if (!even) {
    // Of samples that are lost at random as many are lost two in a row as chance makes them; no
    // clock that is rounded makes three steps of one and two.
    const bool lost = low == 1.0 && less == 0.0 &&
                      longest > kOfChance * longer * longer / shorter && longer < shorter;
    return lost ? std::nullopt : std::optional(out);
  }
  out.rate_hz = 1.0 / h;
  out.t.reserve(t.size());
  for (std::size_t r = 0; r < runs.size(); ++r) {
    double begin = begins[r];
    if (!out.t.empty()) begin = std::max(begin, out.t.back() + 0.5 * h);
    for (std::size_t i = runs[r].first; i < runs[r].end; ++i) {
      out.t.push_back(begin + double(i - runs[r].first) * h);
    }
  }
  return out;
}

}  // namespace magimu
