// SPDX-License-Identifier: BSD-3-Clause
// How magnetometers, and sometimes the others, are read: fault_kinds.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/faults/fault_kinds.h"

namespace magimu {
namespace {

void quantized(Damage& d) {
  d.sensor = 2;
  const double step = d.dice.log_uniform(0.1, 3.0);
  for (int s = 2; s < d.log.sensors(); ++s) {
    for (LogRow& row : d.log.rows) {
      for (double& x : row.v[std::size_t(s)]) x = step * std::round(x / step);
    }
    int& digits = d.log.digits[std::size_t(s)];
    if (digits != kAllDigits) digits = 4;
  }
  d.what = fmt::format("{:.3g} uT", step);
}

// Read faster than it measures: every measurement several times.
void polled(Damage& d) {
  d.sensor = 2;
  const double times = d.dice.uniform(1.5, 8.0);
  for (int s = 2; s < d.log.sensors(); ++s) {
    double measured = -1.0;
    Vector3 value = Vector3::Zero();
    const double dt = times * d.interval_s(s);
    for (const std::size_t r : d.log.rows_of(s)) {
      const double now = std::floor(d.log.rows[r].t / dt);
      if (now != measured) value = d.log.rows[r].v[std::size_t(s)];
      measured = now;
      d.log.rows[r].v[std::size_t(s)] = value;
    }
  }
  d.what = fmt::format("{:.2f} times as fast", times);
}

// Rows of two devices in one file: the other has gains and a bias of its own.
void mixed_devices(Damage& d) {
  const int s = d.choose_mag();
  const std::size_t n = 2 + d.dice.index(3);
  Vector3 gain, bias;
  for (int i = 0; i < 3; ++i) {
    gain[i] = d.dice.uniform(0.8, 1.2);
    bias[i] = d.dice.uniform(-20.0, 20.0);
  }
  const std::vector<std::size_t> rows = d.log.rows_of(s);
  for (std::size_t k = 0; k < rows.size(); k += n) {
    Vector3& v = d.log.rows[rows[k]].v[std::size_t(s)];
    v = gain.cwiseProduct(v) + bias;
  }
  d.what += fmt::format("every {} rows, bias {:.1f} uT", n, bias.norm());
}

// A slower sensor, resampled on straight lines.
void interpolated(Damage& d) {
  const int s = d.dice.chance(0.7) ? d.choose_mag() : d.choose_imu();
  const std::size_t n = 2 + d.dice.index(6);
  const std::vector<std::size_t> rows = d.log.rows_of(s);
  for (std::size_t k = 0; k + n < rows.size(); k += n) {
    const LogRow &a = d.log.rows[rows[k]], &b = d.log.rows[rows[k + n]];
    const Vector3 va = a.v[std::size_t(s)], slope = (b.v[std::size_t(s)] - va) / (b.t - a.t);
    for (std::size_t i = 1; i < n; ++i) {
      LogRow& row = d.log.rows[rows[k + i]];
      row.v[std::size_t(s)] = va + (row.t - a.t) * slope;
    }
  }
  d.what += fmt::format("{} times slower", n);
}

// Its samples are the measurements of some time before.
void late(Damage& d) {
  const int s = d.dice.chance(0.6) ? 2 : d.choose_imu();
  d.sensor = s;
  const double dt = d.interval_s(s), tau = d.dice.log_uniform(0.003, 0.1);
  const std::size_t n = std::max<std::size_t>(1, std::size_t(std::lround(tau / dt)));
  const std::vector<std::size_t> rows = d.log.rows_of(s);
  for (std::size_t k = rows.size() - 1; k >= n; --k) {
    d.log.rows[rows[k]].v[std::size_t(s)] = d.log.rows[rows[k - n]].v[std::size_t(s)];
  }
  for (std::size_t k = 0; k < n && k < rows.size(); ++k) d.log.rows[rows[k]].has &= ~(1u << s);
  d.what = fmt::format("{} by {:.1f} ms", d.log.names[std::size_t(s)], 1e3 * double(n) * dt);
}

// A driver's running mean or low-pass filter.
void smoothed(Damage& d) {
  const int s = d.choose_sensor();
  const double seconds = d.dice.log_uniform(0.01, 0.3), dt = d.interval_s(s);
  const double share = 1.0 - std::exp(-dt / seconds);
  Vector3 slow = Vector3::Zero();
  bool first = true;
  for (const std::size_t r : d.log.rows_of(s)) {
    Vector3& v = d.log.rows[r].v[std::size_t(s)];
    slow = first ? v : Vector3(slow + share * (v - slow));
    first = false;
    v = slow;
  }
  d.what += fmt::format("by {:.1f} ms", 1e3 * seconds);
}

// A hard iron many times the field: harmless, as long as nothing overflows.
void large_hard_iron(Damage& d) {
  d.sensor = 2;
  for (int s = 2; s < d.log.sensors(); ++s) {
    Vector3 by;
    for (double& x : by) x = d.dice.sign() * d.dice.log_uniform(50.0, 1000.0);
    for (LogRow& row : d.log.rows) row.v[std::size_t(s)] += by;
    if (d.truth) d.truth->mag[std::size_t(s - 2)].bias += by;
    d.what += fmt::format("{:.0f} uT ", by.norm());
  }
}

// A screw or a watch comes or goes.
void hard_iron_step(Damage& d) {
  d.sensor = 2;
  const Damage::Stretch stretch = d.stretch(3.0, 60.0);
  Vector3 by;
  for (double& x : by) x = d.dice.normal();
  by *= d.dice.log_uniform(0.5, 100.0) / by.norm();
  constexpr double kUnseen = 0.5;  // s: what comes after it is too short to be told from it
  const bool lasts = d.log.rows.back().t - stretch.t1 < kUnseen;
  for (int s = 2; s < d.log.sensors(); ++s) {
    for (const std::size_t r : d.log.rows_of(s)) {
      if (stretch.has(d.log.rows[r].t)) d.log.rows[r].v[std::size_t(s)] += by;
    }
    // What holds when the recording ends is what is asked for.
    if (lasts && d.truth) d.truth->mag[std::size_t(s - 2)].bias += by;
  }
  d.what += fmt::format("{:.3g} uT", by.norm());
}

// A current that is switched, without its column.
void switched_current(Damage& d) {
  d.sensor = 2;
  const double period = d.dice.uniform(1.0, 15.0), duty = d.dice.uniform(0.2, 0.8);
  Vector3 by;
  for (double& x : by) x = d.dice.normal();
  by *= d.dice.log_uniform(0.2, 20.0) / by.norm();
  for (int s = 2; s < d.log.sensors(); ++s) {
    for (LogRow& row : d.log.rows) {
      const double phase = row.t / period - std::floor(row.t / period);
      if (phase < duty) row.v[std::size_t(s)] += by;
    }
  }
  d.what = fmt::format("{:.3g} uT every {:.1f} s", by.norm(), period);
}

void mains(Damage& d) {
  d.sensor = 2;
  const double f = (d.dice.chance(0.5) ? 50.0 : 60.0) * (1.0 + 2e-4 * d.dice.normal());
  Vector3 a;
  for (double& x : a) x = d.dice.normal();
  a *= d.dice.log_uniform(0.1, 20.0) / a.norm();
  for (int s = 2; s < d.log.sensors(); ++s) {
    for (LogRow& row : d.log.rows) {
      row.v[std::size_t(s)] += std::cos(2.0 * std::numbers::pi * f * row.t) * a;
    }
  }
  d.what = fmt::format("{:.3g} uT, {:.2f} Hz", a.norm(), f);
}

}  // namespace

void add_mag_faults(std::vector<FaultKind>& kinds) {
  const std::vector<std::string> lag = {"lag",    "late",   "delay",    "behind",     "ahead",
                                        "offset", "filter", "interval", "time_offset"};
  std::vector<std::string> smooth = lag;
  smooth.insert(smooth.end(), {"smooth", "colou?r", "correlat", "white", "mean of"});
  const std::vector<std::string> field = {"magnet\\b", "iron",    "disturb", "field",
                                          "current",   "source",  "change",  "jump",
                                          "halves",    "windows", "white"};
  kinds.insert(
      kinds.end(),
      {{.name = "quantized",
        .words = {"quanti", "coarse", "step", "resolution", "converter"},
        .of_sensor = true,
        .apply = quantized},
       {.name = "polled",
        .words = {"repeat", "slower", "more often", "same value", "polled", "measures"},
        .of_sensor = true,
        .info_can_see = true,
        .apply = polled},
       {.name = "mixed_devices",
        .words = {"mixed", "two (sensors|devices)", "another device", "takes turns"},
        .of_sensor = true,
        .info_can_see = true,
        .apply = mixed_devices},
       {.name = "interpolated",
        .words = {"interpolat", "straight line", "slower", "resampl"},
        .of_sensor = true,
        .info_can_see = true,
        .apply = interpolated},
       {.name = "late", .words = lag, .apply = late},
       {.name = "smoothed", .words = smooth, .of_sensor = true, .apply = smoothed},
       {.name = "large_hard_iron", .words = {}, .unnamed = true, .apply = large_hard_iron},
       {.name = "hard_iron_step", .words = field, .of_sensor = true, .apply = hard_iron_step},
       {.name = "switched_current", .words = field, .of_sensor = true, .apply = switched_current},
       {.name = "mains",
        .words = {"mains", "hz", "interference", "periodic", "alternating", "line", "outlier",
                  "noise"},
        .of_sensor = true,
        .apply = mains}});
}

}  // namespace magimu
