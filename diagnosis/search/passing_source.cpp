// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/passing_source.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "calibration/motion/rests/rests.h"
#include "calibration/motion/sensor_rows.h"
#include "diagnosis/search/shapes/excursion_kinds.h"
#include "statistics/median_to_sigma.h"
#include "statistics/quantiles.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr std::size_t kFew = 3;  // one or two may be a hand with a phone, or a magnet being put on
constexpr double kBlock = 0.5;   // s
constexpr std::size_t kFewestBlocks = 40;
constexpr double kTogether = 1.25;    // s between the middles of blocks that are one excursion
constexpr double kOut = 2.0;          // times the usual size of the residual
constexpr double kLongest = 10.0;     // s: what lasts longer is no passing by
constexpr double kException = 0.35;   // of the recording, all excursions together
constexpr double kByChance = 0.01;    // p of axes that agree so well in the sensor's frame
constexpr double kMostlyDelay = 0.5;  // of what turned: a delay makes more than all else
constexpr double kLeastField = 3.5;   // uT at the peak: what a room's own field does not do

// A field that is late by d reads what it was: it departs by -d b x omega. Of unit length, s.
struct Delay {
  double departed = 0.0;  // sum of (b x omega) times the departure
  double moved = 0.0;     // sum of squares of b x omega
  double all = 0.0;       // of the departures
  void add(const Delay& o) {
    departed += o.departed;
    moved += o.moved;
    all += o.all;
  }
  double seconds() const { return moved > 0.0 ? -departed / moved : 0.0; }
  double share() const { return moved * all > 0.0 ? departed * departed / (moved * all) : 0.0; }
};

struct Block {
  double t = 0.0;
  double size = 0.0;     // median of |r|, whitened: single samples do not count
  double field = 0.0;    // RMS over the axes, uT
  double squares = 0.0;  // whitened
  int rows = 0;
  Matrix3 of_device = Matrix3::Zero();  // sum of r r', in the sensor's frame
  Matrix3 of_place = Matrix3::Zero();   // the same in the navigation frame
  double along = 0.0;                   // of squares: of the field's size
  double rate = 0.0;                    // largest, rad/s
  Delay delay;
};

Vector3 rate_at(const VectorSeries& gyr, double t) {
  const auto after = std::lower_bound(gyr.t.begin(), gyr.t.end() - 1, t);
  return gyr.v[std::size_t(after - gyr.t.begin())];
}

// Of one recording, while the sensor moves: nothing passes a resting one.
std::vector<Block> blocks_of(const Recording& recording, const Stage& stage, std::size_t index,
                             const std::vector<TimeSpan>& rests) {
  const Values& values = stage.result().values;
  const LinearSystem system(stage.graph(), values);
  const SensorRows rows(stage.graph(), system);
  const VectorXd r = system.whitened_residuals(values);
  const NodePlan& plan = stage.plans()[index];
  const std::vector<double>& t = plan.t;
  const double nodes_per_s = double(t.size()) / std::max(1e-9, t.back() - t.front());
  const double sigma = stage.spec().noise.mag * std::sqrt(nodes_per_s);
  const auto count = std::size_t((t.back() - t.front()) / kBlock) + 1;
  const Vector3 field_n = unit_field(values.at<double>(dip_of(plan.field)));
  const Vector3 gyr_bias = values.at<Vector3>(key::gyr_bias);
  std::vector<std::vector<double>> all(count);
  std::vector<Block> blocks(count);
  for (int i = 0; i + 2 < system.rows(); ++i) {
    if (rows.sensor[std::size_t(i)] != Sensor::kMag) continue;
    const int node = rows.node[std::size_t(i)] - plan.first;
    if (node < 0 || node >= int(t.size())) continue;
    const double at = t[std::size_t(node)] - t.front();
    const std::size_t b = std::min(count - 1, std::size_t(at / kBlock));
    const Vector3 x = r.segment<3>(i);
    for (const double v : x) all[b].push_back(std::abs(v));
    blocks[b].of_device += x * x.transpose();
    const Rot3 nRb = values.at<Rot3>(R(plan.first + node));
    const Vector3 nx = nRb * x;
    blocks[b].of_place += nx * nx.transpose();
    const int sensor = std::max(0, int(rows.magnetometer[std::size_t(i)]));
    const Matrix3 to_field = sigma * values.at<Matrix3>(key::distortion_of(sensor)).inverse();
    const Vector3 field = nRb.matrix().transpose() * field_n, departed = to_field * x;
    // Half of |b + departed|^2 - |b|^2, however far the field has turned; over its own noise.
    const double size = field.dot(departed) + 0.5 * departed.squaredNorm();
    blocks[b].along += size * size / (to_field.transpose() * field).squaredNorm();
    const Vector3 rate = rate_at(recording.gyr, t[std::size_t(node)]) - gyr_bias;
    blocks[b].rate = std::max(blocks[b].rate, rate.norm());
    const Vector3 moves = field.cross(rate);
    blocks[b].delay.add({moves.dot(departed), moves.squaredNorm(), departed.squaredNorm()});
    i += 2;
  }
  std::vector<Block> out;
  for (std::size_t b = 0; b < count; ++b) {
    if (all[b].size() < 6) continue;
    Block block = blocks[b];
    block.t = t.front() + (double(b) + 0.5) * kBlock;
    block.rows = int(all[b].size());
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

struct Excursion {
  double begin, end, field;
  Matrix3 of_device, of_place;
  AlongField along;
  double rate;
  Delay delay;
};

// Of excursions that only turn the field.
PassingSource turned_field(const std::vector<Excursion>& excursions, const Excursion& largest,
                           double strength_uT) {
  double rate = 0.0;
  Delay delay;
  for (const Excursion& e : excursions) {
    rate = std::max(rate, e.rate);
    delay.add(e.delay);
  }
  PassingSource out;
  out.evidence = fmt::format(
      "In {} short excursions between {:.1f} and {:.1f} s the field that the magnetometer reads is "
      "turned from the predicted one, by up to {:.1f} deg ({:.1f} uT, at {:.1f} s), and has the "
      "predicted size: no magnet or iron does that. The attitude is wrong there, or the times of "
      "the samples, from no cause that is known here. ",
      excursions.size(), excursions.front().begin, excursions.back().end + kBlock,
      largest.field / strength_uT * 180.0 / M_PI, largest.field, largest.begin);
  if (delay.share() > kMostlyDelay) {
    out.evidence += fmt::format(
        "Most of it ({:.0f} %) is as if the magnetometer's samples there were {:.0f} ms {} than "
        "their times say: look at how it is read out and who writes its times.",
        100.0 * delay.share(), 1e3 * std::abs(delay.seconds()),
        delay.seconds() > 0.0 ? "older" : "newer");
  } else {
    out.channel = Sensor::kGyr;
    out.evidence += fmt::format(
        "The gyroscope read up to {:.1f} rad/s there: look whether that is near its range, or the "
        "acceleration near the accelerometer's, or rows were lost or interpolated before, and "
        "record again with a larger range, or turn it more slowly.",
        rate);
  }
  return out;
}

PassingSource source_passed_in(const Recording& recording, const Stage& stage, std::size_t index) {
  if (recording.pos) return {};
  const std::vector<Block> blocks = blocks_of(recording, stage, index, find_rests(recording));
  if (blocks.size() < kFewestBlocks) return {};
  std::vector<double> sizes;
  for (const Block& b : blocks) sizes.push_back(b.size);
  const double usual = median(sizes);

  std::vector<Excursion> excursions;
  double out_s = 0.0, squares = 0.0, rows = 0.0;
  double along_elsewhere = 0.0, rows_elsewhere = 0.0;
  for (const Block& b : blocks) {
    if (b.size < kOut * usual || b.field < kLeastField) {
      along_elsewhere += b.along;
      rows_elsewhere += b.rows;
      continue;
    }
    squares += b.squares;
    rows += b.rows;
    out_s += kBlock;
    if (!excursions.empty() && b.t - excursions.back().end < kTogether) {
      Excursion& e = excursions.back();
      e.end = b.t;
      e.field = std::max(e.field, b.field);
      e.of_device += b.of_device;
      e.of_place += b.of_place;
      e.along.add({b.squares, b.along, b.rows / 3.0});
      e.rate = std::max(e.rate, b.rate);
      e.delay.add(b.delay);
    } else {
      excursions.push_back({b.t,
                            b.t,
                            b.field,
                            b.of_device,
                            b.of_place,
                            {b.squares, b.along, b.rows / 3.0},
                            b.rate,
                            b.delay});
    }
  }
  const double length = blocks.back().t - blocks.front().t;
  const bool lasting = std::any_of(excursions.begin(), excursions.end(),
                                   [](const Excursion& e) { return e.end - e.begin > kLongest; });
  if (excursions.size() < kFew || lasting || out_s > kException * length) return {};

  const auto largest =
      std::max_element(excursions.begin(), excursions.end(),
                       [](const Excursion& a, const Excursion& b) { return a.field < b.field; });
  std::vector<AlongField> along;
  for (const Excursion& e : excursions) along.push_back(e.along);
  if (log_odds_of_turns(along, 3.0 * along_elsewhere / rows_elsewhere) > 0.0) {
    const Matrix3 D = stage.result().values.at<Matrix3>(key::distortion_of(0));
    return turned_field(excursions, *largest, std::cbrt(std::abs(D.determinant())));
  }
  PassingSource out;
  Matrix3 of_device = Matrix3::Zero(), of_place = Matrix3::Zero();
  const auto n = double(excursions.size());
  for (const Excursion& e : excursions) {
    of_device += e.of_device / (n * e.of_device.trace());
    of_place += e.of_place / (n * e.of_place.trace());
  }
  const double lines = log10_p_of_lines(of_device, n);
  if (lines < std::min(std::log10(kByChance), log10_p_of_lines(of_place, n))) {
    const Vector3 u = Eigen::SelfAdjointEigenSolver<Matrix3>(of_device).eigenvectors().col(2);
    out.evidence = fmt::format(
        "In {} short excursions, the largest of {:.1f} uT at {:.1f} s, the magnetometer departs "
        "along one line of its own frame, [{:.2f}, {:.2f}, {:.2f}]: the device makes them (the "
        "current of a motor or of the board, an axis that hangs), no magnet that it passed. With "
        "the current in the column `current` that can be tested.",
        excursions.size(), largest->field, largest->begin, u[0], u[1], u[2]);
    return out;
  }
  // Where more than noise is left throughout, excursions are its peaks and nothing that was passed.
  if (kMedianToSigma * usual > kOut) return {};
  Finding& f = out.finding.emplace();
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
  // The likelihood of their samples with the variance that they have, instead of the noise's.
  const double after = 0.5 * rows * (1.0 + std::log(squares / rows));
  f.gain = {.heldout_nll_before = 0.5 * squares,
            .heldout_nll_after = after,
            .bic_delta = 2.0 * (after - 0.5 * squares) + 2.0 * std::log(rows),
            .residual_rms_before = std::sqrt(squares / rows),
            .residual_rms_after = 1.0};
  f.confusable_with = {{"hard_iron_change",
                        "a magnet that was attached for seconds and removed again",
                        "record positions, or pass the place in several orientations"}};
  return out;
}

}  // namespace

PassingSource find_passing_source(const std::vector<const Recording*>& recordings,
                                  const Stage& stage) {
  PassingSource best;
  if (stage.spec().motion != MotionModel::kHandHeld) return best;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    PassingSource here = source_passed_in(*recordings[r], stage, r);
    const bool better = here.finding && (!best.finding || here.finding->gain.bic_delta <
                                                              best.finding->gain.bic_delta);
    if (better) best.finding = std::move(here.finding);
    if (best.evidence.empty() && !here.evidence.empty()) {
      best.evidence = std::move(here.evidence);
      best.channel = here.channel;
    }
  }
  return best;
}

}  // namespace magimu
