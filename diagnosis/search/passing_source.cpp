// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/passing_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/motion/rests.h"
#include "calibration/motion/sensor_rows.h"
#include "statistics/quantiles.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr std::size_t kFew = 3;  // one or two may be a hand with a phone, or a magnet being put on
constexpr double kBlock = 0.5;   // s
constexpr double kOut = 2.0;     // times the usual size of the residual
constexpr double kLongest = 10.0;    // s: what lasts longer is no passing by
constexpr double kException = 0.35;  // of the recording, all excursions together
constexpr double kLeastField = 3.5;  // uT at the peak: what a room's own field does not do

struct Block {
  double t = 0.0;
  double size = 0.0;     // median of |r|, whitened: single samples do not count
  double field = 0.0;    // RMS over the axes, uT
  double squares = 0.0;  // whitened
  int rows = 0;
};

// Of one recording, while the sensor moves: nothing passes a resting one.
std::vector<Block> blocks_of(const Stage& stage, std::size_t recording,
                             const std::vector<TimeSpan>& rests) {
  const Values& values = stage.result().values;
  const LinearSystem system(stage.graph(), values);
  const SensorRows rows(stage.graph(), system);
  const VectorXd r = system.whitened_residuals(values);
  const NodePlan& plan = stage.plans()[recording];
  const std::vector<double>& t = plan.t;
  const double nodes_per_s = double(t.size()) / std::max(1e-9, t.back() - t.front());
  const double sigma = stage.spec().noise.mag * std::sqrt(nodes_per_s);
  const auto count = std::size_t((t.back() - t.front()) / kBlock) + 1;
  std::vector<std::vector<double>> all(count);
  for (int i = 0; i < system.rows(); ++i) {
    if (rows.sensor[std::size_t(i)] != Sensor::kMag) continue;
    const int node = rows.node[std::size_t(i)] - plan.first;
    if (node < 0 || node >= int(t.size())) continue;
    const double at = t[std::size_t(node)] - t.front();
    all[std::min(count - 1, std::size_t(at / kBlock))].push_back(std::abs(r[i]));
  }
  std::vector<Block> out;
  for (std::size_t b = 0; b < count; ++b) {
    if (all[b].size() < 6) continue;
    Block block{.t = t.front() + (double(b) + 0.5) * kBlock, .rows = int(all[b].size())};
    if (std::ranges::any_of(rests, [&](const TimeSpan& rest) {
          return rest.begin_s <= block.t && block.t <= rest.end_s;
        })) {
      continue;
    }
    for (const double x : all[b]) block.squares += x * x;
    block.field = sigma * std::sqrt(3.0 * block.squares / block.rows);
    block.size = median(all[b]);
    out.push_back(block);
  }
  return out;
}

}  // namespace

namespace {

std::optional<Finding> source_passed_in(const Recording& recording, const Stage& stage,
                                        std::size_t index) {
  if (recording.pos) return std::nullopt;
  const std::vector<Block> blocks = blocks_of(stage, index, find_rests(recording));
  if (blocks.size() < 40) return std::nullopt;
  std::vector<double> sizes;
  for (const Block& b : blocks) sizes.push_back(b.size);
  const double usual = median(sizes);

  struct Excursion {
    double begin, end, field;
  };
  std::vector<Excursion> excursions;
  double out_s = 0.0, squares = 0.0, rows = 0.0;
  for (const Block& b : blocks) {
    if (b.size < kOut * usual || b.field < kLeastField) continue;
    squares += b.squares;
    rows += b.rows;
    out_s += kBlock;
    if (!excursions.empty() && b.t - excursions.back().end < 1.5 * kBlock + 0.5) {
      excursions.back().end = b.t;
      excursions.back().field = std::max(excursions.back().field, b.field);
    } else {
      excursions.push_back({b.t, b.t, b.field});
    }
  }
  const double length = blocks.back().t - blocks.front().t;
  const bool lasting = std::any_of(excursions.begin(), excursions.end(),
                                   [](const Excursion& e) { return e.end - e.begin > kLongest; });
  if (excursions.size() < kFew || lasting || out_s > kException * length) return std::nullopt;

  const auto largest =
      std::max_element(excursions.begin(), excursions.end(),
                       [](const Excursion& a, const Excursion& b) { return a.field < b.field; });
  Finding f;
  f.effect = "stationary_source";
  f.channel = "mag";
  f.sentence = fmt::format(
      "The sensor passed a magnet or iron that stays where it is: {} short excursions of the "
      "field, "
      "the largest of {:.1f} uT at {:.1f} s, tied to neither orientation nor a lasting change. "
      "With "
      "the columns pos_x, pos_y, pos_z its place could be found.",
      excursions.size(), largest->field, largest->begin);
  f.parameters = {{"excursions", double(excursions.size()), 0.0, "1"},
                  {"largest", largest->field, largest->field / std::sqrt(2.0 * 6.0), "uT"},
                  {"at", largest->begin, kBlock, "s"}};
  f.p_value = std::pow(10.0, std::max(-300.0, log10_chi_square_tail(squares, rows)));
  f.probability = 1.0 - f.p_value;
  // Their samples with the size that they have there, instead of the noise's.
  const double after = 0.5 * rows * (1.0 + std::log(squares / rows));
  f.gain = {.heldout_nll_before = 0.5 * squares,
            .heldout_nll_after = after,
            .bic_delta = 2.0 * (after - 0.5 * squares) + 2.0 * std::log(rows),
            .residual_rms_before = std::sqrt(squares / rows),
            .residual_rms_after = 1.0};
  f.confusable_with = {{"hard_iron_change",
                        "a magnet that was attached for seconds and removed again",
                        "record positions, or pass the place in several orientations"}};
  return f;
}

}  // namespace

std::optional<Finding> find_passing_source(const std::vector<const Recording*>& recordings,
                                           const Stage& stage) {
  std::optional<Finding> best;
  if (stage.spec().motion != MotionModel::kHandHeld) return best;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    std::optional<Finding> found = source_passed_in(*recordings[r], stage, r);
    const auto bic = [](const Finding& f) { return f.gain.bic_delta; };
    if (found && (!best || bic(*found) < bic(*best))) best = std::move(found);
  }
  return best;
}

}  // namespace magimu
