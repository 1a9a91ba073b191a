// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/direction_steadiness.h"
#include "statistics/quantiles.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr double kTurn = 0.8;                      // rad between the times of a pair, about
constexpr double kShortest = 2.0, kLongest = 4.0;  // s
// Of a few seconds the pairs are closer, so that there are some: a recording has some dozen at
// least, half an interval apart. A hand's accelerations then average out less.
constexpr double kShortestShare = 1.0 / 12.0, kShortestEver = 0.4;  // of the recording; s
constexpr double kLeastTurn = 0.3;   // rad; pairs that turned less tell little
constexpr double kMeanShare = 0.75;  // of the interval, to average over

// The time in which a turning sensor turns by kTurn: from the upper quartile of the rates, because
// most recordings have rests.
double pair_interval(const VectorSeries& gyr, const Vector3& bias) {
  std::vector<double> rates;
  for (std::size_t k = 0; k < gyr.size(); k += 10) rates.push_back((gyr.v[k] - bias).norm());
  const double upper = quantile(std::move(rates), 0.75);
  const double length = gyr.t.back() - gyr.t.front();
  const double shortest = std::clamp(kShortestShare * length, kShortestEver, kShortest);
  return std::clamp(kTurn / std::max(upper, 1e-3), shortest, kLongest);
}

std::vector<Matrix3> turns(const VectorSeries& gyr, const Vector3& bias,
                           const std::vector<double>& t) {
  const IntegratedRotation integrated(gyr, bias);
  std::vector<Matrix3> out;
  out.reserve(t.size());
  for (const double time : t) out.push_back(integrated.at(time).matrix());
  return out;
}

}  // namespace

DirectionSteadiness::DirectionSteadiness(const VectorSeries& gyr, const Vector3& gyr_bias,
                                         const VectorSeries& directions)
    : mirrored_(gyr), turn_(turns(gyr, gyr_bias, directions.t)), directions_(directions) {
  for (Vector3& v : mirrored_.v) v = -v;
  mirrored_turn_ = turns(mirrored_, -gyr_bias, directions.t);

  const std::vector<double>& t = directions.t;
  const double interval = pair_interval(gyr, gyr_bias), half = 0.5 * kMeanShare * interval;
  const auto at = [&t](double time) {
    return std::size_t(std::lower_bound(t.begin(), t.end(), time) - t.begin());
  };
  const double begin = std::max(t.front(), gyr.t.front()) + half;
  const double end = std::min(t.back(), gyr.t.back()) - half - interval;
  double next = begin;  // at samples: a long gap has none
  for (const double time : t) {
    if (time < next) continue;
    if (time > end) break;
    next = time + 0.5 * interval;
    const double later = time + interval;
    const std::size_t i = std::min(at(time), t.size() - 1), j = std::min(at(later), t.size() - 1);
    const double cosine = 0.5 * ((turn_[i].transpose() * turn_[j]).trace() - 1.0);
    if (std::acos(std::clamp(cosine, -1.0, 1.0)) < kLeastTurn) continue;
    const Pair pair{at(time - half), at(time + half), at(later - half), at(later + half)};
    if (pair.first_i < pair.last_i && pair.first_j < pair.last_j) pairs_.push_back(pair);
  }
}

double DirectionSteadiness::rms_rad(const Matrix3& gyr_axes) const {
  if (pairs_.empty()) return 0.0;
  // Rates P omega turn by P R P'; a G that is no rotation is -P, P omega reversed.
  const bool proper = gyr_axes.determinant() > 0.0;
  const std::vector<Matrix3>& turn = proper ? turn_ : mirrored_turn_;
  const Matrix3 P = proper ? gyr_axes : Matrix3(-gyr_axes);
  std::vector<Vector3> sums{Vector3::Zero()};  // of directions in the frame at the start, less P
  sums.reserve(directions_.size() + 1);
  for (std::size_t k = 0; k < directions_.size(); ++k) {
    sums.push_back(sums.back() + turn[k] * (P.transpose() * directions_.v[k]));
  }
  double squares = 0.0;
  for (const Pair& p : pairs_) {
    const Vector3 a = sums[p.last_i] - sums[p.first_i], b = sums[p.last_j] - sums[p.first_j];
    squares += std::pow(std::atan2(a.cross(b).norm(), a.dot(b)), 2);
  }
  return std::sqrt(squares / double(pairs_.size()));
}

}  // namespace magimu
