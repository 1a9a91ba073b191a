// SPDX-License-Identifier: BSD-3-Clause
// What goes wrong with recordings: buses that hang, converters that overflow, clocks that are set,
// units that nobody wrote down. Each kind damages a log at a random place and size, and says how an
// honest result would name it.
#pragma once

#include <string>
#include <vector>

#include "bench/dice.h"
#include "bench/faults/fault_bases.h"

namespace magimu {

// What a fault works on, and what it leaves word of.
struct Damage {
  const Base& base;
  Dice& dice;
  Log log;
  std::optional<SensorParameters> truth;  // of the damaged recording; none: not known
  int sensor = -1;                        // the damaged one; -1: all, or none
  std::string what;                       // size and place, in words

  // Marks one sensor as the damaged one.
  int choose_sensor();  // any
  int choose_imu();     // accelerometer or gyroscope
  int choose_mag();
  double largest(int s) const;     // absolute reading of any axis
  double interval_s(int s) const;  // the median
  double begin_s() const { return log.rows.front().t; }
  double end_s() const { return log.rows.back().t; }
  // Rows of the sensor, each with that probability, at least one.
  std::vector<std::size_t> some_rows(int s, double share);
  // A single row half of the time, else a share between the two.
  std::vector<std::size_t> few_rows(int s, double least = 1e-3, double most = 0.02);
  // A stretch: from s to the rest of the recording. Says so in `what`.
  struct Stretch {
    double t0, t1;
    bool has(double t) const { return t >= t0 && t < t1; }
  };
  Stretch stretch(double least_s, double most_s);
};

struct FaultKind {
  std::string name;
  // Regular expressions in lower case: one of them must occur in a sentence of the result, ...
  std::vector<std::string> words;
  // ... and, where so marked, the name of the damaged sensor in the same sentence.
  bool of_sensor = false;
  // The recording itself shows it, without a fit: `info` can tell.
  bool info_can_see = false;
  bool needs_simulation = false;
  // Nothing is wrong for a reader who knows such files; or the data cannot show it.
  bool unnamed = false;
  void (*apply)(Damage&);
};

// In an order that never changes: append.
const std::vector<FaultKind>& fault_kinds();
const FaultKind* find_kind(const std::string& name);

// Their parts, by what they spoil.
void add_value_faults(std::vector<FaultKind>& kinds);
void add_stretch_faults(std::vector<FaultKind>& kinds);
void add_time_faults(std::vector<FaultKind>& kinds);
void add_row_faults(std::vector<FaultKind>& kinds);
void add_unit_faults(std::vector<FaultKind>& kinds);
void add_axis_faults(std::vector<FaultKind>& kinds);
void add_mag_faults(std::vector<FaultKind>& kinds);

// Undamaged, to see what is said then.
inline constexpr const char* kNoFault = "none";
Damage undamaged(const Base& base, Dice& dice);
Damage damaged(const Base& base, const FaultKind& kind, Dice& dice);

}  // namespace magimu
