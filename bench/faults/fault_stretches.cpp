// SPDX-License-Identifier: BSD-3-Clause
// Stretches of a recording in which a sensor fails: fault_kinds.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/faults/fault_kinds.h"

namespace magimu {
namespace {

const std::vector<std::string> kHung = {
    "stuck",     "hang",          "hung",     "froze",      "repeat", "does not change",
    "no change", "never changes", "constant", "same value", "held",   "stands still",
    "dead"};

// The bus answers, with what it answered last.
void hang(Damage& d, int s, const Damage::Stretch& stretch) {
  Vector3 last = Vector3::Zero();
  bool known = false;
  for (const std::size_t r : d.log.rows_of(s)) {
    Vector3& v = d.log.rows[r].v[std::size_t(s)];
    if (!stretch.has(d.log.rows[r].t) || !known) {
      last = v;
      known = true;
    } else {
      v = last;
    }
  }
}

void hung(Damage& d) {
  const int s = d.choose_sensor();
  hang(d, s, d.stretch(0.2, 60.0));
}

void hung_bus(Damage& d) {
  const Damage::Stretch stretch = d.stretch(0.2, 60.0);
  for (int s = 0; s < d.log.sensors(); ++s) hang(d, s, stretch);
}

// Again and again, for some tenths of a second.
void hangs_often(Damage& d) {
  const int s = d.choose_sensor(), times = 3 + int(d.dice.index(30));
  for (int i = 0; i < times; ++i) {
    const double t0 = d.dice.uniform(d.begin_s(), d.end_s());
    hang(d, s, {t0, t0 + d.dice.log_uniform(0.05, 0.5)});
  }
  d.what += fmt::format("{} times", times);
}

void dead_axis(Damage& d) {
  const int s = d.choose_sensor(), axis = int(d.dice.index(3));
  const Damage::Stretch stretch = d.stretch(1.0, 60.0);
  const double value = d.dice.chance(0.5) ? 0.0 : d.largest(s);
  for (const std::size_t r : d.log.rows_of(s)) {
    if (stretch.has(d.log.rows[r].t)) d.log.rows[r].v[std::size_t(s)][axis] = value;
  }
}

// The driver gives zeros until its first measurement, or while the sensor is being reset.
void zeros_for_long(Damage& d) {
  const int s = d.choose_sensor();
  Damage::Stretch stretch = d.stretch(0.2, 10.0);
  if (d.dice.chance(0.5)) {
    stretch = {d.begin_s(), d.begin_s() + (stretch.t1 - stretch.t0)};
    d.what += "at the start ";
  }
  for (const std::size_t r : d.log.rows_of(s)) {
    if (stretch.has(d.log.rows[r].t)) d.log.rows[r].v[std::size_t(s)].setZero();
  }
}

void loud_stretch(Damage& d) {
  const int s = d.choose_sensor();
  const Damage::Stretch stretch = d.stretch(0.3, 5.0);
  const double size = d.largest(s) * d.dice.log_uniform(0.05, 1.0);
  for (const std::size_t r : d.log.rows_of(s)) {
    if (!stretch.has(d.log.rows[r].t)) continue;
    for (double& x : d.log.rows[r].v[std::size_t(s)]) x += size * d.dice.normal();
  }
  d.what += fmt::format("sigma {:.3g}", size);
}

void missing(Damage& d, int s, const Damage::Stretch& stretch) {
  for (LogRow& row : d.log.rows) {
    if (stretch.has(row.t)) row.has &= ~(1u << s);
  }
}

void gap_of_a_sensor(Damage& d) {
  const int s = d.choose_sensor();
  missing(d, s, d.stretch(0.5, 30.0));
}

void half_missing(Damage& d) {
  const int s = d.choose_sensor();
  const double middle = 0.5 * (d.begin_s() + d.end_s());
  const bool first = d.dice.chance(0.5);
  missing(d, s, first ? Damage::Stretch{d.begin_s(), middle} : Damage::Stretch{middle, 1e9});
  d.what += first ? "first half" : "second half";
}

void lost_samples(Damage& d) {
  const int s = d.choose_sensor();
  for (const std::size_t r : d.some_rows(s, d.dice.log_uniform(0.01, 0.3))) {
    d.log.rows[r].has &= ~(1u << s);
  }
}

// A magnet, a phone, a steel table beside the sensor while it still lies there: its field passes
// in n, hundreds of milliseconds wide.
void magnet_at_rest(Damage& d) {
  d.sensor = 2;
  const double t0 = d.begin_s() + d.dice.uniform(0.5, 1.5), width = d.dice.uniform(0.3, 1.0);
  Vector3 field;
  for (double& x : field) x = d.dice.normal();
  field *= d.dice.log_uniform(5.0, 200.0) / field.norm();
  for (int s = 2; s < d.log.sensors(); ++s) {
    for (const std::size_t r : d.log.rows_of(s)) {
      const double x = (d.log.rows[r].t - t0) / width;
      if (std::abs(x) < 6.0) d.log.rows[r].v[std::size_t(s)] += std::exp(-0.5 * x * x) * field;
    }
  }
  d.what += fmt::format("{:.3g} uT at {:.2f} s", field.norm(), t0);
}

void shift(Damage& d, int s, const Vector3& by) {
  const Damage::Stretch stretch = d.stretch(1.0, 40.0);
  for (const std::size_t r : d.log.rows_of(s)) {
    if (stretch.has(d.log.rows[r].t)) d.log.rows[r].v[std::size_t(s)] += by;
  }
}

// The gyroscope calibrates itself, a filter starts anew: another bias from here on.
void bias_step(Damage& d) {
  const int s = d.choose_imu();
  Vector3 by;
  for (double& x : by) x = d.dice.normal() * (s == 0 ? 0.1 : 0.01);
  shift(d, s, by);
}

}  // namespace

void add_stretch_faults(std::vector<FaultKind>& kinds) {
  const std::vector<std::string> gap = {"gap",      "missing", "no sample",    "without sample",
                                        "interval", "cover",   "samples from", "different times",
                                        "stops",    "ends at"};
  const std::vector<std::string> lost = {"gap",    "missing",   "lost",     "jitter",
                                         "uneven", "irregular", "interval", "dropped"};
  std::vector<std::string> zeros = kHung;
  zeros.insert(zeros.end(), {"zero", "exactly 0", "0, 0, 0", "clip"});
  kinds.insert(
      kinds.end(),
      {{.name = "hung", .words = kHung, .of_sensor = true, .info_can_see = true, .apply = hung},
       {.name = "hung_bus", .words = kHung, .info_can_see = true, .apply = hung_bus},
       {.name = "hangs_often",
        .words = kHung,
        .of_sensor = true,
        .info_can_see = true,
        .apply = hangs_often},
       {.name = "dead_axis",
        .words = zeros,
        .of_sensor = true,
        .info_can_see = true,
        .apply = dead_axis},
       {.name = "zeros_for_long",
        .words = zeros,
        .of_sensor = true,
        .info_can_see = true,
        .apply = zeros_for_long},
       {.name = "loud_stretch",
        .words = {"noise", "outlier", "disturb", "windows", "scatter", "spike", "jump", "set aside",
                  "residual"},
        .of_sensor = true,
        .apply = loud_stretch},
       {.name = "gap_of_a_sensor",
        .words = gap,
        .of_sensor = true,
        .info_can_see = true,
        .apply = gap_of_a_sensor},
       {.name = "half_missing",
        .words = gap,
        .of_sensor = true,
        .info_can_see = true,
        .apply = half_missing},
       {.name = "lost_samples", .words = lost, .of_sensor = true, .apply = lost_samples},
       {.name = "magnet_at_rest",
        .words = {"magnet\\b", "disturb", "source", "iron",
                  "field (change"
                  "|depart|was|is not)",
                  "windows", "passing"},
        .needs_simulation = true,
        .apply = magnet_at_rest},
       {.name = "bias_step",
        .words = {"bias", "jump", "step", "change", "halves", "drift", "disturb"},
        .of_sensor = true,
        .apply = bias_step}});
}

}  // namespace magimu
