// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/held_out.h"

#include <algorithm>
#include <cmath>

#include "calibration/fit/side_by_side.h"
#include "calibration/model/gathered.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr double kLeftOut = 5.0;  // s left out at a time, half of a recording at the most

// The nodes at which one magnetometer measured.
std::vector<int> nodes_of(const Stage& stage, std::size_t mag) {
  std::vector<int> out;
  for (std::size_t r = 0; r < stage.plans().size(); ++r) {
    const std::vector<NodeMean>& means = stage.gathered().mag(int(r), int(mag));
    for (std::size_t i = 0; i < means.size(); ++i) {
      if (means[i].independent > 0.0) out.push_back(stage.plans()[r].first + int(i));
    }
  }
  return out;
}

// The block that each node's time falls into; blocks of all recordings are numbered through.
std::vector<int> blocks_of(const std::vector<NodePlan>& plans) {
  std::vector<int> out;
  int first = 0;
  for (const NodePlan& plan : plans) {
    int last = first;
    const double all = plan.t.back() - plan.t.front(), length = std::min(kLeftOut, 0.5 * all);
    const int blocks = length > 0.0 ? int(std::ceil(all / length)) : 1;
    for (const double t : plan.t) {
      const double passed = length > 0.0 ? (t - plan.t.front()) / length : 0.0;
      last = first + std::min(int(passed), blocks - 1);
      out.push_back(last);
    }
    first = last + 1;
  }
  return out;
}

// With which of the two fits each block is left out: in turn, among those in which a magnetometer
// measured. Throws NumericalError where one of them measured in those of one turn alone.
std::vector<int> turn_of_blocks(const Stage& stage, const std::vector<int>& block) {
  std::vector<std::vector<int>> measured;  // blocks of each magnetometer
  std::vector<int> any(std::size_t(block.back()) + 1, 0);
  for (std::size_t m = 0; m < stage.spec().mag_offset_s.size(); ++m) {
    std::vector<int>& own = measured.emplace_back();
    for (const int node : nodes_of(stage, m)) own.push_back(block[std::size_t(node)]);
    for (const int b : own) any[std::size_t(b)] = 1;
  }
  std::vector<int> turn;
  int before = 0;
  for (const int measures : any) {
    turn.push_back(before % 2);
    before += measures;
  }
  for (const std::vector<int>& own : measured) {
    const auto turn_of = [&](int b) { return turn[std::size_t(b)]; };
    if (std::ranges::find(own, 0, turn_of) == own.end() ||
        std::ranges::find(own, 1, turn_of) == own.end()) {
      throw NumericalError("a magnetometer measured at no other time");
    }
  }
  return turn;
}

}  // namespace

BlockErrors block_errors(const Stage& stage) {
  const std::vector<int> block = blocks_of(stage.plans()), turn = turn_of_blocks(stage, block);
  double nodes = 0.0, seconds = 0.0;
  for (const NodePlan& plan : stage.plans()) {
    nodes += double(plan.t.size());
    seconds += plan.t.back() - plan.t.front();
  }
  // Whitened by density times sqrt(samples a second / samples a node).
  const double scale = nodes / std::max(seconds, 1e-9);
  const std::vector<double> zero(std::size_t(block.back()) + 1, 0.0);
  BlockErrors out{zero, zero, 0.0};
  const auto add = [&](const Stage& from, std::vector<double>& sums, int of_turn) {
    const std::vector<double> squares = from.mag_squares_uT();
    for (std::size_t i = 0; i < squares.size(); ++i) {
      const auto own = std::size_t(block[i]);
      if (of_turn < 0 || turn[own] == of_turn) sums[own] += squares[i] * scale;
    }
  };
  out.values = 3.0 * double(block.size() * stage.spec().mag_offset_s.size());
  add(stage, out.fitted, -1);
  const auto leave_out = [&](int of_turn) {
    Stage without = stage;
    without.fit_without(stage.result().values, [&](int node) {
      return turn[std::size_t(block[std::size_t(node)])] == of_turn;
    });
    add(without, out.held_out, of_turn);
  };
  // The two leave out different blocks, so that none is written to by both.
  side_by_side(
      stage.plans(), [&] { leave_out(0); }, [&] { leave_out(1); });
  return out;
}

double HeldOutGain::ratio() const { return std::exp(0.5 * mean); }

HeldOutGain held_out_gain(const Stage& first, const Stage& second) {
  BlockErrors a, b;
  side_by_side(
      first.plans(), [&] { a = block_errors(first); }, [&] { b = block_errors(second); });
  return held_out_gain(a, b);
}

HeldOutGain held_out_gain(const BlockErrors& first, const BlockErrors& second) {
  double sum = 0.0, sum2 = 0.0, n = 0.0;
  for (std::size_t i = 0; i < first.held_out.size(); ++i) {
    // Of no samples nothing is predicted.
    if (first.held_out[i] == 0.0 && second.held_out[i] == 0.0) continue;
    n += 1.0;
    const double d =
        std::log(std::max(first.held_out[i], 1e-30) / std::max(second.held_out[i], 1e-30));
    sum += d;
    sum2 += d * d;
  }
  if (n == 0.0) return {};
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(1e-12, sum2 / n - mean * mean) / n)};
}

}  // namespace magimu
