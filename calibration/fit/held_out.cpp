// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/held_out.h"

#include <algorithm>
#include <cmath>

#include "calibration/fit/side_by_side.h"

namespace magimu {
namespace {

constexpr double kLeftOut = 5.0;  // s left out at a time, half of a recording at the most

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

}  // namespace

BlockErrors block_errors(const Stage& stage) {
  const std::vector<int> block = blocks_of(stage.plans());
  double nodes = 0.0, seconds = 0.0;
  for (const NodePlan& plan : stage.plans()) {
    nodes += double(plan.t.size());
    seconds += plan.t.back() - plan.t.front();
  }
  // Whitened by density times sqrt(samples a second / samples a node).
  const double scale = nodes / std::max(seconds, 1e-9);
  const std::vector<double> zero(std::size_t(block.back()) + 1, 0.0);
  BlockErrors out{zero, zero, 0.0};
  const auto add = [&](const Stage& from, std::vector<double>& sums, int parity) {
    const std::vector<double> squares = from.mag_squares_uT();
    for (std::size_t i = 0; i < squares.size(); ++i) {
      if (parity < 0 || block[i] % 2 == parity) sums[std::size_t(block[i])] += squares[i] * scale;
    }
  };
  out.values = 3.0 * double(block.size() * stage.spec().mag_offset_s.size());
  add(stage, out.fitted, -1);
  const auto leave_out = [&](int parity) {
    Stage without = stage;
    without.fit_without(stage.result().values,
                        [&](int node) { return block[std::size_t(node)] % 2 == parity; });
    add(without, out.held_out, parity);
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
  double sum = 0.0, sum2 = 0.0;
  const auto n = double(first.held_out.size());
  for (std::size_t i = 0; i < first.held_out.size(); ++i) {
    const double d =
        std::log(std::max(first.held_out[i], 1e-30) / std::max(second.held_out[i], 1e-30));
    sum += d;
    sum2 += d * d;
  }
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(1e-12, sum2 / n - mean * mean) / n)};
}

}  // namespace magimu
