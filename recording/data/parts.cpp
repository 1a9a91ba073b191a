// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/parts.h"
#include "statistics/quantiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace magimu {
namespace {

// What gravity alone tells of an attitude while a hand accelerates the sensor by 1 m/s^2, rad.
constexpr double kFreshStart = 0.1;
constexpr double kBridgeStep = 0.05;  // s, of the lengths tried
constexpr double kBridgeIntervals =
    4.0;  // usual intervals that are no gap in any case (check_times)
constexpr double kUpperQuartile = 0.75;      // of the turn's errors: three in four are less
constexpr std::size_t kBridgeStarts = 2000;  // instants looked at
constexpr double kLeastPart = 1.0;  // s: of a part; its first velocity alone takes half of that
constexpr std::size_t kLeastSamples = 10;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Break {
  double begin, end;  // the last sample before it, and the first one after it
};

void add_breaks(const std::vector<double>& t, double limit, std::vector<Break>& gaps) {
  if (t.empty()) return;
  for (std::size_t k = 1; k < t.size(); ++k) {
    if (t[k] - t[k - 1] > limit) gaps.push_back({t[k - 1], t[k]});
  }
}

std::vector<Break> breaks_of(const Recording& r) {
  std::vector<Break> gaps;
  if (r.gyr.size() < 2 || r.acc.size() < 2) return gaps;
  const double limit = longest_bridge(r);
  add_breaks(r.gyr.t, limit, gaps);
  add_breaks(r.acc.t, limit, gaps);
  // Where one of the two begins later or ends earlier the other is alone.
  if (std::abs(r.gyr.t.front() - r.acc.t.front()) > limit) {
    gaps.push_back({-kInfinity, std::max(r.gyr.t.front(), r.acc.t.front())});
  }
  if (std::abs(r.gyr.t.back() - r.acc.t.back()) > limit) {
    gaps.push_back({std::min(r.gyr.t.back(), r.acc.t.back()), kInfinity});
  }
  std::ranges::sort(gaps, {}, &Break::begin);
  std::vector<Break> apart;
  for (const Break& gap : gaps) {
    if (!apart.empty() && gap.begin <= apart.back().end) {
      apart.back().end = std::max(apart.back().end, gap.end);
    } else {
      apart.push_back(gap);
    }
  }
  return apart;
}

std::string sentence_of(const std::vector<Recording>& dropped) {
  std::string where;
  for (std::size_t i = 0; i < dropped.size() && i < 3; ++i) {
    const std::vector<double>& t = dropped[i].gyr.empty() ? dropped[i].acc.t : dropped[i].gyr.t;
    if (t.empty()) continue;
    where += fmt::format("{}{:.2f}-{:.2f} s", where.empty() ? "" : ", ", t.front(), t.back());
  }
  if (dropped.size() > 3) where += fmt::format(" and {} more", dropped.size() - 3);
  return fmt::format("{}: {} between long gaps {} too short to tell anything and left out: {}.",
                     dropped.front().name, dropped.size() == 1 ? "one part" : "parts",
                     dropped.size() == 1 ? "is" : "are", where);
}

}  // namespace

double longest_bridge(const Recording& recording) {
  const VectorSeries& gyr = recording.gyr;
  const std::size_t n = gyr.size();
  const double rate = std::min(gyr.rate_hz(), recording.acc.rate_hz());
  const double least = rate > 0.0 ? kBridgeIntervals / rate : 0.0;
  if (n < 2) return std::max(kLongestBridge, least);
  std::vector<Vector3> turned{Vector3::Zero()};
  for (std::size_t k = 0; k + 1 < n; ++k) {
    turned.push_back(turned.back() + gyr.v[k] * (gyr.t[k + 1] - gyr.t[k]));
  }
  const double usual = 1.0 / gyr.rate_hz();
  const std::size_t stride = n / kBridgeStarts + 1;
  for (double length = kBridgeStep; length < kLongestBridge; length += kBridgeStep) {
    // By how much a turn departs from what the rate at its beginning makes it.
    std::vector<double> errors;
    for (std::size_t k = 0; k < n; k += stride) {
      const auto j =
          std::size_t(std::ranges::lower_bound(gyr.t, gyr.t[k] + length) - gyr.t.begin());
      if (j >= n || gyr.t[j] - gyr.t[k] > length + kBridgeIntervals * usual) continue;
      const double dt = gyr.t[j] - gyr.t[k];
      errors.push_back((turned[j] - turned[k] - gyr.v[k] * dt).norm());
    }
    if (errors.empty()) continue;
    // The upper quartile, since most recordings have rests.
    if (quantile(std::move(errors), kUpperQuartile) > kFreshStart) return std::max(length, least);
  }
  return std::max(kLongestBridge, least);
}

bool tells_something(const Recording& part) {
  const auto few = [](const VectorSeries& s) { return s.size() < kLeastSamples; };
  if (few(part.acc) || few(part.gyr) || part.mag.empty() || few(part.mag.front())) return false;
  if (part.gyr.t.back() - part.gyr.t.front() < kLeastPart) return false;
  const std::vector<double>& mag = part.mag.front().t;
  const auto first = std::ranges::lower_bound(mag, part.gyr.t.front());
  const auto last = std::ranges::upper_bound(mag, part.gyr.t.back());
  return last - first >= std::ptrdiff_t(kLeastSamples);
}

std::optional<std::vector<Recording>> parts_of(const Recording& recording,
                                               std::vector<std::string>& warnings) {
  const std::vector<Break> gaps = breaks_of(recording);
  if (gaps.empty()) return std::nullopt;
  std::vector<Recording> parts, dropped;
  double begin = -kInfinity;
  for (std::size_t i = 0; i <= gaps.size(); ++i) {
    const double end = i < gaps.size() ? std::nextafter(gaps[i].begin, kInfinity) : kInfinity;
    Recording part = slice(recording, begin, end);
    if (i < gaps.size()) begin = gaps[i].end;
    if (part.gyr.empty() && part.acc.empty()) continue;
    if (!tells_something(part)) {
      dropped.push_back(std::move(part));
      continue;
    }
    part.continues_previous = parts.empty() ? recording.continues_previous : true;
    parts.push_back(std::move(part));
  }
  if (!dropped.empty()) warnings.push_back(sentence_of(dropped));
  return parts;
}

}  // namespace magimu
