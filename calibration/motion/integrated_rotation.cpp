// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/integrated_rotation.h"

#include <algorithm>
#include <cmath>

#include "calibration/motion/sample_times.h"

namespace magimu {
namespace {

// What an accelerometer reads while sample k stands for it, half an interval to either side.
struct Held {
  Vector3 mean, slope;
};

// Of the parabola through the sample and its neighbours: the sample alone is wrong by h^2 / 24
// times the second derivative, which a turning or swinging sensor shows as an error of scale.
Held held(const VectorSeries& s, std::size_t k) {
  if (!is_evenly_spaced(s.t, k)) return {s.v[k], Vector3::Zero()};
  return {(s.v[k - 1] + 22.0 * s.v[k] + s.v[k + 1]) / 24.0,
          (s.v[k + 1] - s.v[k - 1]) / (s.t[k + 1] - s.t[k - 1])};
}

}  // namespace

IntegratedRotation::IntegratedRotation(const VectorSeries& gyr, const Vector3& bias,
                                       const GyroMatrix& matrix)
    : gyr_(gyr),
      bias_(bias),
      matrix_(matrix),
      unscale_((Matrix3::Identity() + square_matrix(matrix)).inverse()) {
  attitude_.reserve(gyr.size());
  attitude_.emplace_back();
  for (std::size_t k = 0; k + 1 < gyr.size(); ++k) {
    const Vector3 v = rate_of(k) * (gyr.t[k + 1] - gyr.t[k]);
    attitude_.push_back((attitude_.back() * Rot3::Exp(v)).normalized());
  }
}

std::size_t IntegratedRotation::sample_at(double t) const { return sample_until(gyr_.t, t); }

// Of what the gyroscope reads within the interval of sample k, rad/s^2; 0 at the ends and beside
// gaps.
Vector3 IntegratedRotation::slope_of(std::size_t k) const {
  if (k == 0 || k + 2 >= gyr_.size()) return Vector3::Zero();
  const double before = gyr_.t[k] - gyr_.t[k - 1], own = gyr_.t[k + 1] - gyr_.t[k],
               after = gyr_.t[k + 2] - gyr_.t[k + 1];
  if (std::max(std::abs(before - own), std::abs(after - own)) > kUneven * own) {
    return Vector3::Zero();
  }
  return (gyr_.v[k + 1] - gyr_.v[k - 1]) / (0.5 * before + own + 0.5 * after);
}

// What it would read from a to b, a part of the interval of sample k: the sample's mean alone would
// set the attitude between two samples off by T^2 / 12 times the change of the rate, which looks
// like a filter in every other sensor. All parts together lead as far as the sample itself (the
// cross product: Baker, Campbell and Hausdorff to second order), as at() has it.
Vector3 IntegratedRotation::reading_of(std::size_t k, double a, double b) const {
  if (k + 1 >= gyr_.size()) return gyr_.v[k];
  const Vector3 slope = slope_of(k);
  const double begin = a - gyr_.t[k], end = b - gyr_.t[k], whole = gyr_.t[k + 1] - gyr_.t[k];
  return gyr_.v[k] + slope * (0.5 * (begin + end - whole)) -
         (gyr_.v[k] - bias_).cross(slope) * (0.25 * begin * end);
}

Vector3 IntegratedRotation::rate(double t) const {
  const std::size_t k = sample_at(t);
  if (k + 1 >= gyr_.size() || t < gyr_.t[k]) return rate_of(k);
  return rate_of(k) + unscale_ * slope_of(k) * (t - 0.5 * (gyr_.t[k] + gyr_.t[k + 1]));
}

Rot3 IntegratedRotation::at(double t) const {
  const std::size_t k = sample_at(t);
  if (t == gyr_.t[k]) return attitude_[k];
  const double s = t - gyr_.t[k];
  Vector3 turned = rate_of(k) * s;
  if (k + 1 < gyr_.size() && s > 0.0) {
    turned -= unscale_ * slope_of(k) * (0.5 * s * (gyr_.t[k + 1] - t));
  }
  return attitude_[k] * Rot3::Exp(turned);
}

PreintegratedGyroscope IntegratedRotation::preintegrate(double a, double b,
                                                        const EffectColumns* effects) const {
  PreintegratedGyroscope out(bias_);
  SampleColumns columns(effects);
  std::size_t k = sample_at(a);
  double t = a;
  while (t < b) {
    const double end = k + 1 < gyr_.size() ? std::min(b, gyr_.t[k + 1]) : b;
    if (end > t) out.integrate(reading_of(k, t, end), end - t, columns.of(k));
    t = std::max(t, end);
    ++k;
  }
  return out;
}

PreintegratedImu IntegratedRotation::preintegrate(double a, double b, const VectorSeries& acc,
                                                  const Vector3& acc_bias, bool with_matrix,
                                                  const EffectColumns* gyr_effects,
                                                  const EffectColumns* acc_effects) const {
  constexpr double kSliver = 1e-9;  // s: pieces shorter than this are rounding
  PreintegratedImu out(bias_, acc_bias, with_matrix ? std::optional(matrix_) : std::nullopt);
  SampleColumns gyr_columns(gyr_effects), acc_columns(acc_effects);
  std::size_t g = sample_at(a);
  // The accelerometer's sample nearest to a.
  const auto end_of = [&](std::size_t k) {
    return k + 1 < acc.size() ? 0.5 * (acc.t[k] + acc.t[k + 1]) : b;
  };
  std::size_t k = sample_until(acc.t, a);
  if (k + 1 < acc.size() && end_of(k) <= a + kSliver) ++k;
  // Where no sample ends in between one piece would be all, whose noise, held, moves velocity and
  // position alike: their covariance would be singular. Two halves with noise of their own, as
  // between most nodes.
  const double next_gyr = g + 1 < gyr_.size() ? gyr_.t[g + 1] : b;
  const bool one_piece =
      b - a > 4.0 * kSliver && next_gyr >= b - kSliver && end_of(k) >= b - kSliver;
  const double middle = one_piece ? 0.5 * (a + b) : b;
  double t = a;
  while (t < b - kSliver) {
    const double gyr_end = g + 1 < gyr_.size() ? gyr_.t[g + 1] : b;
    const double end = std::min({t < middle ? middle : b, gyr_end, std::max(end_of(k), t)});
    if (end > t + kSliver) {
      const Held force = held(acc, k);
      const Vector3 mean = force.mean + force.slope * (0.5 * (t + end) - acc.t[k]);
      out.integrate(reading_of(g, t, end), mean, end - t, gyr_columns.of(g), acc_columns.of(k),
                    force.slope);
      t = end;
    }
    if (g + 1 < gyr_.size() && gyr_end <= t + kSliver) ++g;
    if (k + 1 < acc.size() && end_of(k) <= t + kSliver) ++k;
  }
  return out;
}

}  // namespace magimu
