// SPDX-License-Identifier: BSD-3-Clause
// What simulated boards print, row by row, and what comes over the wire of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/dice.h"
#include "bench/faults/fault_log.h"
#include "factors/sensor_model.h"

namespace magimu {

struct BoardPlan {
  std::uint64_t seed = 1;
  bool hand_held = false;  // else the board is turned on the spot
  double rate_hz = 100.0;
  double duration_s = 60.0;
  double rest_s = -1.0;  // negative: the motion's own
};

struct BoardLog {
  Log log;  // with as many digits as a logger prints, time in s with 6 decimals
  SensorParameters truth;
  double rate_hz = 0.0;
};

BoardLog simulated_board(const BoardPlan& plan);

// The magnetometer measures once in `ratio` rows, at a phase drawn from the dice, and every row
// repeats the last reading. Rows before the first reading have none.
void hold_magnetometer(Log& log, double ratio, Dice& dice);

// Rows first to last (exclusive), with the header.
std::string part_text(const Log& log, std::size_t first, std::size_t last);
// The same without the header.
std::string rows_text(const Log& log, std::size_t first, std::size_t last);

// The header at first and again every 1000 rows, as boards do that do not know who listens.
std::string text_with_headers(const Log& log);

// Each byte after the first line is replaced, with that probability, by a random one.
std::string garbled(const std::string& text, double probability, Dice& dice, long* errors);

}  // namespace magimu
