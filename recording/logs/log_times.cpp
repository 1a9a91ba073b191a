// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/log_times.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "recording/data/times/arrival_stamps.h"

namespace magimu {
namespace {

constexpr std::int64_t kJump = 1'000'000'000;              // ns, as row_times' least
constexpr std::int64_t kClockSet = 1'000'000'000'000'000;  // ns: longer than a log
constexpr int kSwappedRows = 8;                            // as row_times'
constexpr std::int64_t kNoTime = std::numeric_limits<std::int64_t>::min();

// b - a >= least, without overflow.
bool later_by(std::int64_t a, std::int64_t b, std::int64_t least) {
  return b >= a && static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a) >=
                       static_cast<std::uint64_t>(least);
}

// Calls use(sensor, time, whether a row begins) for each sample.
template <class F>
void in_rows(const std::vector<LogTimes>& sensors, const std::vector<std::uint8_t>& order,
             const F& use) {
  std::vector<std::size_t> next(sensors.size(), 0);
  std::uint32_t bits = 0;
  std::int64_t row_time = kNoTime;
  for (const std::uint8_t s : order) {
    const std::int64_t t = (*sensors[s].t_ns)[next[s]++];
    const bool same = bits != 0 && t == row_time && (bits & sensors[s].bit) == 0;
    bits = (same ? bits : 0) | sensors[s].bit;
    row_time = t;
    if (!use(s, t, !same)) return;
  }
}

// Sensors that share rows, each sensor in one group.
std::vector<std::uint32_t> groups_of(const std::vector<LogTimes>& sensors,
                                     const std::vector<std::uint8_t>& order) {
  std::vector<std::uint32_t> groups;
  std::uint32_t bits = 0, last = 0;
  const auto join = [&](std::uint32_t all) {
    if (all == last || all == 0) return;
    last = all;
    std::erase_if(groups, [&all](std::uint32_t g) {
      if ((g & all) == 0) return false;
      all |= g;
      return true;
    });
    groups.push_back(all);
  };
  in_rows(sensors, order, [&](std::uint8_t s, std::int64_t, bool begins) {
    if (begins) join(std::exchange(bits, 0));
    bits |= sensors[s].bit;
    return true;
  });
  join(bits);
  return groups;
}

// Calls use(seconds between two times one after another) for all times of a group.
template <class F>
void each_interval(const std::vector<const std::vector<std::int64_t>*>& times, const F& use) {
  std::vector<std::size_t> next(times.size(), 0);
  std::int64_t before = kNoTime;
  while (true) {
    std::int64_t t = std::numeric_limits<std::int64_t>::max();
    bool any = false;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (next[i] == times[i]->size()) continue;
      any = true;
      t = std::min(t, (*times[i])[next[i]]);
    }
    if (!any) return;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (next[i] < times[i]->size() && (*times[i])[next[i]] == t) ++next[i];
    }
    if (before != kNoTime) use(log_seconds(t, before));
    before = t;
  }
}

bool may_be_stamped_on_arrival(const std::vector<LogTimes>& sensors, std::uint32_t group) {
  std::vector<const std::vector<std::int64_t>*> times;
  for (const LogTimes& sensor : sensors) {
    if ((sensor.bit & group) != 0) times.push_back(sensor.t_ns);
  }
  BriefIntervals brief;
  each_interval(times, [&](double s) { brief.add(s); });
  each_interval(times, [&](double s) { brief.count(s); });
  return brief.may_be_bursts();
}

}  // namespace

std::optional<std::size_t> late_rows_of_orderly(const std::vector<LogTimes>& sensors,
                                                const std::vector<std::uint8_t>& order) {
  std::vector<std::int64_t> last(sensors.size(), kNoTime);
  std::int64_t newest = kNoTime, jumped_from = kNoTime;
  int since_jump = kSwappedRows;
  std::size_t late = 0;
  bool orderly = true;
  in_rows(sensors, order, [&](std::uint8_t s, std::int64_t t, bool begins) {
    orderly = t > last[s];
    last[s] = t;
    if (!orderly || !begins) return orderly;
    if (newest == kNoTime) {
      newest = t;
      return true;
    }
    // Ahead for a moment, and back again: the time may be damaged.
    if (since_jump < kSwappedRows) {
      ++since_jump;
      orderly = t < jumped_from || later_by(jumped_from, t, kJump);
    }
    if (later_by(newest, t, kJump)) {
      orderly = orderly && since_jump == kSwappedRows && !later_by(newest, t, kClockSet);
      jumped_from = newest;
      since_jump = 0;
    }
    late += t < newest ? 1 : 0;
    newest = std::max(newest, t);
    return orderly;
  });
  if (!orderly) return std::nullopt;
  for (const std::uint32_t group : groups_of(sensors, order)) {
    if (may_be_stamped_on_arrival(sensors, group)) return std::nullopt;
  }
  return late;
}

RawRows rows_of_log(const std::vector<LogTimes>& sensors, const std::vector<std::uint8_t>& order,
                    std::int64_t origin_ns, double shift_s,
                    std::vector<std::vector<std::uint32_t>>& row) {
  RawRows rows;
  row.assign(sensors.size(), {});
  for (std::size_t s = 0; s < sensors.size(); ++s) row[s].reserve(sensors[s].t_ns->size());
  in_rows(sensors, order, [&](std::uint8_t s, std::int64_t t, bool begins) {
    if (begins) {
      rows.time.push_back(log_seconds(t, origin_ns) + shift_s);
      rows.sensors.push_back(0);
      rows.line.push_back(static_cast<std::uint32_t>(rows.time.size()));
    }
    rows.sensors.back() |= sensors[s].bit;
    row[s].push_back(static_cast<std::uint32_t>(rows.time.size() - 1));
    return true;
  });
  return rows;
}

}  // namespace magimu
