// SPDX-License-Identifier: BSD-3-Clause
// Faults in general: fault_kinds.h.
#include "bench/faults/fault_kinds.h"

#include <fmt/format.h>

#include <algorithm>

namespace magimu {

int Damage::choose_sensor() {
  sensor = int(dice.index(3));
  if (sensor == 2) choose_mag();
  what += log.names[std::size_t(sensor)] + ' ';
  return sensor;
}

int Damage::choose_imu() {
  sensor = int(dice.index(2));
  what += log.names[std::size_t(sensor)] + ' ';
  return sensor;
}

int Damage::choose_mag() {
  sensor = 2 + int(dice.index(std::size_t(base.magnetometers())));
  return sensor;
}

double Damage::largest(int s) const {
  double most = 0.0;
  for (const std::size_t r : log.rows_of(s)) {
    most = std::max(most, log.rows[r].v[std::size_t(s)].cwiseAbs().maxCoeff());
  }
  return most;
}

double Damage::interval_s(int s) const {
  const std::vector<std::size_t> rows = log.rows_of(s);
  std::vector<double> dt;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    dt.push_back(log.rows[rows[k]].t - log.rows[rows[k - 1]].t);
  }
  if (dt.empty()) return 0.0;
  std::nth_element(dt.begin(), dt.begin() + std::ptrdiff_t(dt.size() / 2), dt.end());
  return dt[dt.size() / 2];
}

std::vector<std::size_t> Damage::some_rows(int s, double share) {
  const std::vector<std::size_t> rows = log.rows_of(s);
  std::vector<std::size_t> some;
  for (const std::size_t r : rows) {
    if (dice.chance(share)) some.push_back(r);
  }
  if (some.empty()) some.push_back(dice.pick(rows));
  what += fmt::format("{} of {} samples ", some.size(), rows.size());
  return some;
}

std::vector<std::size_t> Damage::few_rows(int s, double least, double most) {
  if (dice.chance(0.5)) return some_rows(s, 0.0);
  return some_rows(s, dice.log_uniform(least, most));
}

Damage::Stretch Damage::stretch(double least_s, double most_s) {
  const double length = end_s() - begin_s();
  const bool to_the_end = dice.chance(0.2);
  const double t0 = begin_s() + length * dice.uniform(to_the_end ? 0.2 : 0.05, 0.9);
  const double t1 =
      to_the_end ? end_s() + 1.0 : t0 + dice.log_uniform(least_s, std::min(most_s, 0.3 * length));
  what += fmt::format("from {:.3f} to {:.3f} s ", t0, std::min(t1, end_s()));
  return {t0, t1};
}

const std::vector<FaultKind>& fault_kinds() {
  static const std::vector<FaultKind> kinds = [] {
    std::vector<FaultKind> all;
    add_value_faults(all);
    add_stretch_faults(all);
    add_time_faults(all);
    add_row_faults(all);
    add_unit_faults(all);
    add_axis_faults(all);
    add_mag_faults(all);
    return all;
  }();
  return kinds;
}

const FaultKind* find_kind(const std::string& name) {
  for (const FaultKind& kind : fault_kinds()) {
    if (kind.name == name) return &kind;
  }
  return nullptr;
}

Damage undamaged(const Base& base, Dice& dice) {
  return {.base = base, .dice = dice, .log = base.log, .truth = base.truth, .what = ""};
}

Damage damaged(const Base& base, const FaultKind& kind, Dice& dice) {
  Damage damage = undamaged(base, dice);
  kind.apply(damage);
  return damage;
}

}  // namespace magimu
