// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/gate_witnesses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

namespace magimu {
namespace {

constexpr double kTurningRate = 0.2;    // rad/s: the device turns
constexpr double kTurnedEnough = 0.15;  // rad: a turn by which any reading changes
constexpr double kSlowly = 5.0;  // a rate is slow that is so many times below the fastest tenth
constexpr double kTurningShare =
    0.3;  // change of gravity or the field, as a share, that shows a turn

// A step of gravity or the field is looked for in readings up to kStepReach_s on either side, with
// at least and at most so many readings.
constexpr double kStepReach_s = 0.1, kFewReadings = 6.0, kManyReadings = 32.0;
constexpr double kFewestReadings = 3.0, kSameRow = 0.25;
// Prior odds, ln 10, for garbage against a turn that lasts one sample: a real turn usually leaves a
// tail.
constexpr double kLogOddsOfTurn = 2.3;

std::pair<std::size_t, std::size_t> span_within(const VectorSeries& s, double begin, double end) {
  const auto first = std::ranges::lower_bound(s.t, begin),
             last = std::ranges::upper_bound(s.t, end);
  return {std::size_t(first - s.t.begin()), std::size_t(std::max(first, last) - s.t.begin())};
}

std::vector<double> lengths_within(const VectorSeries& s, double begin, double end) {
  std::vector<double> out;
  const auto [first, last] = span_within(s, begin, end);
  for (std::size_t k = first; k < last; ++k) {
    if (s.v[k].allFinite()) out.push_back(s.v[k].norm());
  }
  return out;
}

double size_quantile(std::vector<double> x, double share) {
  if (x.empty()) return 0.0;
  const auto at = x.begin() + std::ptrdiff_t(share * double(x.size() - 1));
  std::ranges::nth_element(x, at);
  return *at;
}

bool changed(const VectorSeries& s, double begin, double end) {
  const auto [first, last] = span_within(s, begin, end);
  if (last <= first) return false;
  double squares = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> x;
    for (std::size_t k = first; k < last; ++k) {
      if (s.v[k].allFinite()) x.push_back(s.v[k][axis]);
    }
    const double range = size_quantile(x, 0.9) - size_quantile(x, 0.1);
    squares += range * range;
  }
  return std::sqrt(squares) > kTurningShare * size_quantile(lengths_within(s, begin, end), 0.5);
}

// The step of a series at a time: constant on either side, beside a parabola through all readings.
struct Step {
  Vector3 size, mean;
  double variance;  // variance of the step, of each axis
};

std::optional<Step> step_at(const VectorSeries& s, double begin, double end) {
  const double interval = 1.0 / std::max(s.rate_hz(), 1e-9);
  const double reach = std::clamp(kStepReach_s, kFewReadings * interval, kManyReadings * interval);
  const double middle = 0.5 * (begin + end);
  const auto [first, last] = span_within(s, middle - reach, middle + reach);
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> b = Eigen::Matrix<double, 4, 3>::Zero();
  Step out{Vector3::Zero(), Vector3::Zero(), 0.0};
  double squares = 0.0, n = 0.0, after = 0.0;
  for (std::size_t k = first; k < last; ++k) {
    // The reading at that time is left out: a failed transfer may have spoilt all sensors.
    const double x = (s.t[k] - middle) / reach;
    if (!s.v[k].allFinite() || std::abs(s.t[k] - begin) < kSameRow * interval) continue;
    const Eigen::Vector4d row(1.0, x, x * x, x > 0.0 ? 1.0 : 0.0);
    A += row * row.transpose();
    b += row * s.v[k].transpose();
    squares += s.v[k].squaredNorm();
    out.mean += s.v[k];
    after += row[3];
    n += 1.0;
  }
  if (after < kFewestReadings || n - after < kFewestReadings) return std::nullopt;
  const Eigen::LDLT<Eigen::Matrix4d> ldlt(A);
  const Eigen::Matrix<double, 4, 3> c = ldlt.solve(b);
  const Eigen::Vector4d last_column = ldlt.solve(Eigen::Vector4d::UnitW());
  const double left = std::max(squares - (c.array() * b.array()).sum(), 1e-12 * squares);
  out.size = c.row(3).transpose();
  out.mean /= n;
  out.variance = left / (3.0 * (n - 4.0)) * last_column[3];
  return out;
}

}  // namespace

GateWitnesses::GateWitnesses(const Recording& recording)
    : recording_(recording),
      usual_rate_(size_quantile(lengths_within(recording.gyr, -1e300, 1e300), 0.9)) {}

bool GateWitnesses::turned(Sensor hung, double begin, double end) const {
  const double rate = size_quantile(lengths_within(recording_.gyr, begin, end), 0.5);
  const double usual =
      usual_rate_ / kSlowly;  // relative to the usual rate, as the unit may be wrong
  if (rate > std::max({kTurningRate, kTurnedEnough / (end - begin), usual})) return true;
  if (hung == Sensor::kMag || recording_.mag.empty()) return false;
  return changed(recording_.mag.front(), begin, end) &&
         (hung == Sensor::kAcc || changed(recording_.acc, begin, end));
}

bool GateWitnesses::turned_by(double begin, double end, const Vector3& more) const {
  const Vector3 angle = more * (end - begin);
  double log_odds = 0.0;
  // A vector u that is fixed in the navigation frame changes by -angle x u in the device.
  if (const auto force = step_at(recording_.acc, begin, end)) {
    const Vector3 turned = -angle.cross(force->mean);
    log_odds +=
        0.5 * (force->size.squaredNorm() - (force->size - turned).squaredNorm()) / force->variance;
  }
  // Hard iron is unknown, and so is the direction of the field. On each axis the step may be as
  // large as if the field were perpendicular to the turn.
  if (recording_.mag.empty()) return log_odds > kLogOddsOfTurn;
  if (const auto field = step_at(recording_.mag.front(), begin, end)) {
    const double wide = field->variance + angle.squaredNorm() * field->mean.squaredNorm();
    log_odds += 0.5 * field->size.squaredNorm() * (1.0 / field->variance - 1.0 / wide) -
                1.5 * std::log(wide / field->variance);
  }
  return log_odds > kLogOddsOfTurn;
}

bool GateWitnesses::others_change(Sensor hung, double begin, double end) const {
  const auto changes = [&](const VectorSeries& s) {
    const auto [first, last] = span_within(s, begin, end);
    std::size_t differ = 0;
    for (std::size_t k = first + 1; k < last; ++k) differ += s.v[k] != s.v[k - 1] ? 1 : 0;
    return last > first + 1 && 2 * differ > last - first;
  };
  return (hung != Sensor::kGyr && changes(recording_.gyr)) ||
         (hung != Sensor::kAcc && changes(recording_.acc)) ||
         (hung != Sensor::kMag && std::ranges::any_of(recording_.mag, changes));
}

}  // namespace magimu
