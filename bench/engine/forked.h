// SPDX-License-Identifier: BSD-3-Clause
// Runs something in a process of its own, so that its memory can be told from everybody else's, a
// limit on its time be kept, and whatever it breaks stay there. Linux and other Unix systems.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "graph/values.h"

namespace magimu {

// Wall and processor time since its making, all threads.
class Stopwatch {
 public:
  Stopwatch();
  double wall_s() const;
  double cpu_s() const;

 private:
  double wall_, cpu_;
};

// Of the cost: solvers stop after a step that gains less; the next would gain far less.
constexpr double kSmallGain = 1e-9;

// What a solver hands back; the times are its own, without what comes before and after.
struct Solved {
  Values values;
  int iterations = 0;
  bool converged = false;
  double wall_s = 0.0, cpu_s = 0.0;
};

struct Measured {
  double wall_s = 0.0, cpu_s = 0.0, cost = 0.0;
  int iterations = 0;
  bool converged = false;
  double memory_mb = 0.0;  // at the most, above what the process had in the beginning
  std::string failure;     // empty: none
};

// Solves twice, the second time with warm memory, and tells of the second; only once where that
// took more than kLong seconds. cost: of the values found. Nothing may have started threads before.
Measured measure_in_child(const std::function<Solved()>& solve,
                          const std::function<double(const Values&)>& cost, int limit_s);

}  // namespace magimu
