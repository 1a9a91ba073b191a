// SPDX-License-Identifier: BSD-3-Clause
// Simulated boards: board_logs.h.
#include "bench/boards/board_logs.h"

#include <algorithm>
#include <cmath>

#include "sim/simulate.h"

namespace magimu {
namespace {

constexpr double kBoardGravity = 9.80665;
constexpr std::size_t kHeaderEvery = 1000;  // rows

// Decimals so fine that rounding is less than half a standard deviation of the noise.
int decimals(double density, double rate_hz) {
  return std::max(2, int(std::ceil(-std::log10(density * std::sqrt(rate_hz)))));
}

}  // namespace

BoardLog simulated_board(const BoardPlan& plan) {
  SimulationOptions o;
  o.seed = plan.seed;
  o.gravity = kBoardGravity;
  o.motion = plan.hand_held ? SimulatedMotion::kHandHeld : SimulatedMotion::kHand;
  o.rate_hz = plan.rate_hz;
  o.duration_s = plan.duration_s;
  o.rest_s = plan.rest_s;
  const Simulation simulation = simulate(o);
  BoardLog board{log_of(simulation.recording), simulation.truth.parameters, plan.rate_hz};
  const NoiseDensities& noise = simulation.truth.noise;
  board.log.digits = {decimals(noise.acc, o.rate_hz), decimals(noise.gyr, o.rate_hz),
                      decimals(noise.mag, o.rate_hz)};
  board.log.time_digits = 6;
  return board;
}

void hold_magnetometer(Log& log, double ratio, Dice& dice) {
  constexpr int kMag = 2;
  double next = dice.uniform(0.0, ratio);  // in rows
  Vector3 last = Vector3::Zero();
  bool any = false;
  for (std::size_t k = 0; k < log.rows.size(); ++k) {
    LogRow& row = log.rows[k];
    if (double(k) >= next) {
      last = row.v[kMag];
      any = true;
      next += ratio;
    }
    if (any) {
      row.v[kMag] = last;
    } else {
      row.has &= ~(1u << kMag);
    }
  }
}

std::string rows_text(const Log& log, std::size_t first, std::size_t last) {
  std::string text;
  for (std::size_t k = first; k < std::min(last, log.rows.size()); ++k) {
    text += row_text(log, log.rows[k]) + '\n';
  }
  return text;
}

std::string part_text(const Log& log, std::size_t first, std::size_t last) {
  return header_text(log) + '\n' + rows_text(log, first, last);
}

std::string text_with_headers(const Log& log) {
  std::string text;
  for (std::size_t k = 0; k < log.rows.size(); k += kHeaderEvery) {
    text += part_text(log, k, k + kHeaderEvery);
  }
  return text;
}

std::string garbled(const std::string& text, double probability, Dice& dice, long* errors) {
  std::string out = text;
  *errors = 0;
  // From error to error: distances between them are geometric.
  const double log_none = std::log1p(-probability);
  const auto distance = [&] { return 1.0 + std::floor(std::log(1.0 - dice.uniform()) / log_none); };
  for (double at = double(text.find('\n')) + distance(); at < double(text.size());
       at += distance()) {
    char& byte = out[std::size_t(at)];
    const char before = byte;
    while (byte == before) byte = char(dice.index(256));
    ++*errors;
  }
  return out;
}

}  // namespace magimu
