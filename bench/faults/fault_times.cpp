// SPDX-License-Identifier: BSD-3-Clause
// Clocks that are set, run over, drift or are none: fault_kinds.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/faults/fault_kinds.h"

namespace magimu {
namespace {

constexpr double kEpoch = 1.7e9;  // s since 1970, in 2023

std::size_t middle_row(Damage& d) {
  const double n = double(d.log.rows.size());
  return std::size_t(n * d.dice.uniform(0.1, 0.9));
}

void shift_from(Damage& d, std::size_t first, double by) {
  for (std::size_t r = first; r < d.log.rows.size(); ++r) d.log.rows[r].t += by;
}

// The board resets, and its clock begins at 0; or somebody sets it.
void clock_back(Damage& d) {
  const std::size_t r = middle_row(d);
  const double t = d.log.rows[r].t;
  const double by = d.dice.chance(0.5) ? t - d.begin_s() : d.dice.log_uniform(0.05, t);
  d.what = fmt::format("at {:.3f} s by {:.3f} s", t, by);
  shift_from(d, r, -by);
}

void clock_forward(Damage& d) {
  const std::size_t r = middle_row(d);
  const double by = d.dice.log_uniform(1.0, 86400.0);
  d.what = fmt::format("at {:.3f} s by {:.1f} s", d.log.rows[r].t, by);
  shift_from(d, r, by);
}

// micros() of 32 bits.
void rollover(Damage& d) {
  constexpr double kPeriod = 4294.967296;
  const double at = d.log.rows[middle_row(d)].t;
  for (LogRow& row : d.log.rows) {
    row.t = std::round(1e6 * std::fmod(row.t - at + 2.0 * kPeriod, kPeriod)) * 1e-6;
  }
  d.what = fmt::format("at {:.3f} s", at);
}

// Nothing is logged for a while, and the device is turned meanwhile.
void gap_of_all(Damage& d) {
  const double length = d.dice.log_uniform(1.0, 20.0);
  const double t0 = d.log.rows[middle_row(d)].t;
  std::erase_if(d.log.rows, [&](const LogRow& r) { return r.t >= t0 && r.t < t0 + length; });
  d.what = fmt::format("from {:.3f} s, {:.3f} s", t0, length);
}

void gap_of_a_day(Damage& d) {
  gap_of_all(d);
  double longest = 0.0;
  std::size_t after = d.log.rows.size();
  for (std::size_t r = 1; r < d.log.rows.size(); ++r) {
    if (d.log.rows[r].t - d.log.rows[r - 1].t <= longest) continue;
    longest = d.log.rows[r].t - d.log.rows[r - 1].t;
    after = r;
  }
  const double by = d.dice.log_uniform(60.0, 86400.0);
  shift_from(d, after, by);
  d.what += fmt::format(" and {:.0f} s", by);
}

void in_unit(Damage& d, double per_second, double epoch, int digits) {
  for (LogRow& row : d.log.rows) row.t = (row.t + epoch) * per_second;
  d.log.time_digits = digits;
  d.log.time_name = d.dice.chance(0.5) ? "t" : "timestamp";
}
void epoch_us(Damage& d) { in_unit(d, 1e6, kEpoch, 0); }
void epoch_ms(Damage& d) { in_unit(d, 1e3, kEpoch, d.base.rate_hz > 400.0 ? 3 : 0); }
void epoch_s(Damage& d) { in_unit(d, 1.0, kEpoch, 6); }
void milliseconds(Damage& d) { in_unit(d, 1e3, 0.0, d.base.rate_hz > 400.0 ? 3 : 0); }
void microseconds(Damage& d) { in_unit(d, 1e6, 0.0, 0); }

void counter(Damage& d) {
  for (std::size_t r = 0; r < d.log.rows.size(); ++r) d.log.rows[r].t = double(r);
  d.log.time_digits = 0;
  d.log.time_name = d.dice.chance(0.5) ? "t" : "time";
}

// Several samples come together, stamped as they arrive.
void bursts(Damage& d) {
  const std::size_t n = 2 + d.dice.index(15);
  for (std::size_t r = 0; r < d.log.rows.size(); r += n) {
    const std::size_t last = std::min(r + n, d.log.rows.size()) - 1;
    const double arrival = d.log.rows[last].t;
    for (std::size_t i = r; i <= last; ++i) {
      d.log.rows[i].t = arrival + 2e-4 * double(i - r) * std::min(1.0, 100.0 / d.base.rate_hz);
    }
  }
  d.log.time_digits = std::max(d.log.time_digits, 6);
  d.what = fmt::format("{} at a time", n);
}

void jitter(Damage& d) {
  const double share = d.dice.log_uniform(0.01, 0.3), dt = d.interval_s(1);
  double before = -1e9;
  for (LogRow& row : d.log.rows) {
    row.t = std::max(row.t + share * dt * d.dice.normal(), before + 1e-5);
    before = row.t;
  }
  d.what = fmt::format("{:.1f} % of an interval", 100.0 * share);
}

// Stamps on arrival, each late by its own delay; now and then by much.
void late_stamps(Damage& d) {
  const double mean = d.dice.log_uniform(0.001, 0.02);
  double before = -1e9;
  for (LogRow& row : d.log.rows) {
    row.t = std::max(row.t - mean * std::log(1.0 - d.dice.uniform()), before + 1e-5);
    before = row.t;
  }
  d.what = fmt::format("by {:.1f} ms on average", 1e3 * mean);
}

void coarse_time(Damage& d) {
  const double step = d.dice.pick<double>({0.001, 0.002, 0.01});
  for (LogRow& row : d.log.rows) row.t = step * std::floor(row.t / step);
  d.log.time_digits = 3;
  d.what = fmt::format("in steps of {} s", step);
}

void clock_rate(Damage& d) {
  const double kappa = d.dice.sign() * d.dice.log_uniform(1e-4, 0.05);
  for (LogRow& row : d.log.rows) row.t *= 1.0 + kappa;
  d.what = fmt::format("by {:.4g} %", 100.0 * kappa);
}

// It warms up: its rate changes over the recording.
void clock_drift(Damage& d) {
  const double most = d.dice.sign() * d.dice.log_uniform(1e-3, 0.05), begin = d.begin_s();
  const double length = d.end_s() - begin;
  for (LogRow& row : d.log.rows) {
    const double x = row.t - begin;
    row.t = begin + x + 0.5 * most * x * x / length;
  }
  d.what = fmt::format("to {:.3g} %", 100.0 * most);
}

}  // namespace

void add_time_faults(std::vector<FaultKind>& kinds) {
  const std::vector<std::string> clock = {
      "clock",    "time (does not|goes|jump|is set|step|begin|start)",
      "backward", "comes after",
      "reset",    "gap",
      "new part", "parts",
      "missing"};
  const std::vector<std::string> unit = {
      "t=us",  "t=ms",       "microsecond",         "millisecond",
      "epoch", "since 1970", "unit of (the )?time", "time.* in (us|ms)"};
  const std::vector<std::string> uneven = {"jitter", "uneven",    "irregular", "arriv", "burst",
                                           "stamp",  "at a time", "interval",  "gap",   "clock"};
  const std::vector<std::string> rate = {"clock", "rate", "scale", "gyroscope.*(scale|gain|reads)"};
  kinds.insert(
      kinds.end(),
      {{.name = "clock_back", .words = clock, .info_can_see = true, .apply = clock_back},
       {.name = "clock_forward", .words = clock, .info_can_see = true, .apply = clock_forward},
       {.name = "rollover", .words = clock, .info_can_see = true, .apply = rollover},
       {.name = "gap_of_all", .words = clock, .info_can_see = true, .apply = gap_of_all},
       {.name = "gap_of_a_day", .words = clock, .info_can_see = true, .apply = gap_of_a_day},
       {.name = "epoch_us", .words = unit, .info_can_see = true, .apply = epoch_us},
       {.name = "epoch_ms", .words = unit, .info_can_see = true, .apply = epoch_ms},
       {.name = "epoch_s", .words = unit, .unnamed = true, .apply = epoch_s},
       {.name = "milliseconds", .words = unit, .info_can_see = true, .apply = milliseconds},
       {.name = "microseconds", .words = unit, .info_can_see = true, .apply = microseconds},
       {.name = "counter",
        .words = {"count", "not a time", "no time", "sample number", "index", "--rate",
                  "t=", "unit"},
        .info_can_see = true,
        .apply = counter},
       {.name = "bursts", .words = uneven, .info_can_see = true, .apply = bursts},
       {.name = "jitter", .words = uneven, .apply = jitter},
       {.name = "late_stamps", .words = uneven, .apply = late_stamps},
       {.name = "coarse_time", .words = uneven, .apply = coarse_time},
       {.name = "clock_rate", .words = rate, .apply = clock_rate},
       {.name = "clock_drift", .words = rate, .apply = clock_drift}});
}

}  // namespace magimu
