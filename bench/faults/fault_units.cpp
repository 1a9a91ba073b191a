// SPDX-License-Identifier: BSD-3-Clause
// Numbers in another unit than the header says, or of the wrong size: fault_kinds.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/faults/fault_kinds.h"

namespace magimu {
namespace {

// So many digits fewer or more as the numbers are larger or smaller.
void scale(Damage& d, int s, double factor) {
  for (LogRow& row : d.log.rows) row.v[std::size_t(s)] *= factor;
  int& digits = d.log.digits[std::size_t(s)];
  if (digits != kAllDigits) digits = std::max(0, digits + int(std::ceil(-std::log10(factor))));
}

void scale_mags(Damage& d, double factor) {
  d.sensor = 2;
  for (int s = 2; s < d.log.sensors(); ++s) scale(d, s, factor);
}

void counts(Damage& d, int s, double per_unit) {
  scale(d, s, per_unit);
  d.log.digits[std::size_t(s)] = 0;
  d.what += fmt::format("{:.5g} counts per unit", per_unit);
}

void mag_nT(Damage& d) { scale_mags(d, 1000.0); }
void mag_mG(Damage& d) { scale_mags(d, 10.0); }
void mag_gauss(Damage& d) { scale_mags(d, 0.01); }
void mag_tesla(Damage& d) { scale_mags(d, 1e-6); }
// LIS3MDL at 4 and 16 gauss, HMC5883L, QMC5883L, MMC5983MA (16 bits), AK8963, ADIS16470.
void mag_counts(Damage& d) {
  d.sensor = 2;
  const double per_uT = d.dice.pick<double>({68.42, 17.11, 10.9, 120.0, 40.96, 6.67, 1.0 / 0.15});
  for (int s = 2; s < d.log.sensors(); ++s) counts(d, s, per_uT);
}

// The driver divides by the length: 1, or 50 uT.
void mag_normalised(Damage& d) {
  d.sensor = 2;
  const double length = d.dice.pick<double>({1.0, 50.0, 100.0});
  for (int s = 2; s < d.log.sensors(); ++s) {
    for (LogRow& row : d.log.rows) row.v[std::size_t(s)] *= length / row.v[std::size_t(s)].norm();
    int& digits = d.log.digits[std::size_t(s)];
    if (digits != kAllDigits) digits = 5;
  }
  d.what = fmt::format("to {}", length);
}

void of_acc(Damage& d, double factor) {
  d.sensor = 0;
  scale(d, 0, factor);
}
void acc_g(Damage& d) { of_acc(d, 1.0 / 9.80665); }
void acc_mg(Damage& d) { of_acc(d, 1000.0 / 9.80665); }
void acc_counts(Damage& d) {
  d.sensor = 0;
  counts(d, 0, d.dice.pick<double>({16384.0, 8192.0, 4096.0, 2048.0, 256.0}) / 9.80665);
}
// A range of 2 g taken for 4 g.
void acc_twice(Damage& d) { of_acc(d, d.dice.chance(0.5) ? 2.0 : 0.5); }
void acc_gain(Damage& d) {
  const double gain = 1.0 + d.dice.sign() * d.dice.log_uniform(0.002, 0.2);
  of_acc(d, gain);
  d.what = fmt::format("{:.4f}", gain);
}
// A phone's linear acceleration: gravity has been taken out, with a filter's small errors.
void acc_without_gravity(Damage& d) {
  d.sensor = 0;
  Vector3 slow = d.log.rows.front().v[0];
  for (const std::size_t r : d.log.rows_of(0)) {
    Vector3& v = d.log.rows[r].v[0];
    slow += std::min(1.0, 20.0 / d.base.rate_hz) * (v - slow);
    v -= slow;
  }
}

void of_gyr(Damage& d, double factor) {
  d.sensor = 1;
  scale(d, 1, factor);
}
void gyr_deg(Damage& d) { of_gyr(d, 1.0 / kDegree); }
void gyr_tenth_deg(Damage& d) {
  d.sensor = 1;
  counts(d, 1, 10.0 / kDegree);
}
void gyr_mrad(Damage& d) { of_gyr(d, 1000.0); }
void gyr_counts(Damage& d) {
  d.sensor = 1;
  counts(d, 1, d.dice.pick<double>({131.0, 65.5, 32.8, 16.4, 114.3, 57.1}) / kDegree);
}
// A range taken for its neighbour.
void gyr_range(Damage& d) {
  const double factor = d.dice.pick<double>({2.0, 0.5, 4.0, 0.25});
  of_gyr(d, factor);
  d.what = fmt::format("times {}", factor);
}
void gyr_gain(Damage& d) {
  const double gain = 1.0 + d.dice.sign() * d.dice.log_uniform(0.002, 0.2);
  of_gyr(d, gain);
  if (d.truth) d.truth->gyr_bias *= gain;
  d.what = fmt::format("{:.4f}", gain);
}
// Radians where degrees were converted twice.
void gyr_too_small(Damage& d) { of_gyr(d, kDegree); }
// The sum of several samples, or the angle of one interval, instead of a rate.
void gyr_increments(Damage& d) { of_gyr(d, d.interval_s(1)); }

// Each sensor in units of its own full range.
void shares_of_range(Damage& d) {
  d.sensor = -1;
  for (int s = 0; s < d.log.sensors(); ++s) {
    scale(d, s, 1.0 / (d.largest(s) * 1.2));
    int& digits = d.log.digits[std::size_t(s)];
    if (digits != kAllDigits) digits = 6;
  }
}

}  // namespace

void add_unit_faults(std::vector<FaultKind>& kinds) {
  const std::vector<std::string> unit = {"unit",
                                         "--unit",
                                         "count",
                                         "gauss",
                                         "\\bmg\\b",
                                         "nanotesla",
                                         "\\bnt\\b",
                                         "deg/s",
                                         "in g\\b",
                                         "milli",
                                         "tesla",
                                         "times (the|too)",
                                         "factor",
                                         "ratio",
                                         "as (large|small|fast)",
                                         "too (large|small|fast|slow)"};
  std::vector<std::string> gain = unit;
  gain.insert(gain.end(), {"scale", "gain", "range", "gravity", "reads .* (much|little|rate)"});
  const auto add = [&](const char* name, const std::vector<std::string>& words, bool seen,
                       void (*apply)(Damage&)) {
    kinds.push_back(
        {.name = name, .words = words, .of_sensor = true, .info_can_see = seen, .apply = apply});
  };
  add("mag_nT", unit, true, mag_nT);
  add("mag_mG", unit, true, mag_mG);
  add("mag_gauss", unit, true, mag_gauss);
  add("mag_tesla", unit, true, mag_tesla);
  add("mag_counts", unit, true, mag_counts);
  add("mag_normalised", {"normali[sz]ed", "same length", "constant length", "unit vector"}, true,
      mag_normalised);
  add("acc_g", unit, true, acc_g);
  add("acc_mg", unit, true, acc_mg);
  add("acc_counts", unit, true, acc_counts);
  add("acc_twice", gain, true, acc_twice);
  add("acc_gain", gain, false, acc_gain);
  add("acc_without_gravity", {"gravity", "linear acceleration"}, true, acc_without_gravity);
  add("gyr_deg", unit, true, gyr_deg);
  add("gyr_tenth_deg", unit, true, gyr_tenth_deg);
  add("gyr_mrad", unit, true, gyr_mrad);
  add("gyr_counts", unit, true, gyr_counts);
  add("gyr_range", gain, true, gyr_range);
  add("gyr_gain", gain, false, gyr_gain);
  add("gyr_too_small", unit, true, gyr_too_small);
  add("gyr_increments", unit, true, gyr_increments);
  add("shares_of_range", unit, true, shares_of_range);
  kinds.back().of_sensor = false;
}

}  // namespace magimu
