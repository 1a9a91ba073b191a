// SPDX-License-Identifier: BSD-3-Clause
// The effects on accelerometer and gyroscope, one equation each: imu_model.h.
#include "tests/oracle/imu_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/oracle/random.h"

namespace magimu::oracle {
namespace {

constexpr double kBlowSeconds = 0.010, kBlowHz = 40.0;

Vector3d lower_triangle_times(const Effect& e, const Vector3d& f) {
  return {e[0] * f.x(), e[1] * f.x() + e[2] * f.y(), e[3] * f.x() + e[4] * f.y() + e[5] * f.z()};
}

}  // namespace

Matrix3d first_matrix(const Effect& e) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(e.parameters.data());
}

double legendre(int j, double x) {
  double before = 1.0, now = x;
  if (j == 0) return before;
  for (int n = 1; n < j; ++n) {
    const double next = ((2 * n + 1) * x * now - n * before) / (n + 1);
    before = now;
    now = next;
  }
  return now;
}

Vector3d polynomial(const Effect& e, double x, int first) {
  Vector3d sum = Vector3d::Zero();
  for (int j = 0; 3 * j < e.parameters.size(); ++j) sum += e.vector(3 * j) * legendre(first + j, x);
  return sum;
}

double phase(const Motion& motion, double t) { return 2.0 * t / motion.duration_s() - 1.0; }

bool lasts(const Effect& e, int i, double t) { return t >= e[i] && t < e[i + 1]; }

Vector3d mean_about(double t, double width, const std::function<Vector3d(double)>& f) {
  if (width == 0.0) return f(t);
  constexpr int kPoints = 50;
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < kPoints; ++i) sum += f(t + width * ((i + 0.5) / kPoints - 0.5));
  return sum / kPoints;
}

void stick(std::vector<Vector3d>& readings, double width) {
  for (std::size_t k = 1; width > 0.0 && k < readings.size(); ++k) {
    const Vector3d least = readings[k].array() - width, most = readings[k].array() + width;
    readings[k] = readings[k - 1].cwiseMax(least).cwiseMin(most);
  }
}

Instant instant(const Motion& motion, double gravity, double t) {
  Instant at;
  at.t = t;
  at.bRn = motion.nRb(t).conjugate().toRotationMatrix();
  at.omega = motion.omega(t);
  at.p = motion.position(t);
  at.f = at.bRn * (motion.acceleration(t) + Vector3d(0.0, 0.0, gravity));
  return at;
}

ImuModel::ImuModel(const Options& options, const Device& device, const Motion& motion,
                   const std::vector<double>& true_t)
    : options_(options), device_(device), motion_(motion), t_(true_t), gravity_(options.gravity) {
  for (std::size_t k = 0; k + 1 < t_.size(); ++k) mean_temperature_ += options.temperature(t_[k]);
  mean_temperature_ /= static_cast<double>(t_.size() - 1);
  for (const Effect& e : options.effects) {
    if (e.kind == EffectKind::kGravity) gravity_ += e[0];
    if (e.kind == EffectKind::kAccTimeOffset) acc_offset_ += e[0];
    if (e.kind == EffectKind::kAccBandwidth) acc_mean_s_ += std::sqrt(12.0 * e[0]);
    if (e.kind == EffectKind::kGyroBiasDrift) draw_drift(e[0]);
    if (e.kind == EffectKind::kAccTapping) draw_taps(e);
    if (e.kind == EffectKind::kGyroGSensitivity || e.kind == EffectKind::kGyroRectification) {
      gyr_needs_force_ = true;
    }
  }
}

Vector3d ImuModel::acc_at(double t) const {
  const Instant at = instant(motion_, gravity_, t);
  Vector3d acc = at.f + device_.acc_bias;
  for (const Effect& e : options_.effects) {
    switch (e.kind) {
      case EffectKind::kAccScaleMisalignment:
        acc += lower_triangle_times(e, at.f);
        break;
      case EffectKind::kAccChange:
        if (lasts(e, 9, t)) acc += first_matrix(e) * (at.f + device_.acc_bias);
        break;
      case EffectKind::kAccNonlinearity:
        acc.array() += e.vector().array() * at.f.array().cube() / (9.80665 * 9.80665);
        break;
      case EffectKind::kAccGainDrift:
        acc += polynomial(e, phase(motion_, t), 0).cwiseProduct(at.f + device_.acc_bias);
        break;
      case EffectKind::kAccBiasDrift:
        acc += polynomial(e, phase(motion_, t));
        break;
      case EffectKind::kAccBiasChange:
        if (lasts(e, 3, t)) acc += e.vector();
        break;
      case EffectKind::kAccTemperature:
        acc += e.vector() * (options_.temperature(t) - mean_temperature_);
        break;
      case EffectKind::kLeverArm:
        acc += motion_.angular_acceleration(t).cross(e.vector()) +
               at.omega.cross(at.omega.cross(e.vector()));
        break;
      default:
        break;
    }
  }
  for (const Tap& tap : taps_) {
    const double since = t - tap.t;
    if (since < 0.0 || since > 12.0 * kBlowSeconds) continue;
    acc += tap.size * std::exp(-since / kBlowSeconds) *
           std::sin(2.0 * std::numbers::pi * kBlowHz * since);
  }
  return acc;
}

Vector3d ImuModel::gyr_at(double t) const {
  const Vector3d omega = motion_.omega(t);
  const Vector3d f =
      gyr_needs_force_ ? instant(motion_, gravity_, t).f : Vector3d(Vector3d::Zero());
  Vector3d gyr = omega + device_.gyr_bias;
  for (const Effect& e : options_.effects) {
    switch (e.kind) {
      case EffectKind::kGyroScaleMisalignment:
        gyr += e.matrix() * omega;
        break;
      case EffectKind::kGyroGSensitivity:
        gyr += e.matrix() * f;
        break;
      case EffectKind::kGyroNonlinearity:
        gyr.array() += e.vector().array() * omega.array() * omega.array().abs();
        break;
      case EffectKind::kGyroTemperature:
        gyr += e.vector() * (options_.temperature(t) - mean_temperature_);
        break;
      case EffectKind::kGyroRectification:
        gyr.array() += e.vector().array() * f.array().square();
        break;
      case EffectKind::kGyroChange:
        if (lasts(e, 9, t)) gyr += first_matrix(e) * (omega + device_.gyr_bias);
        break;
      case EffectKind::kGyroGainDrift:
        gyr += polynomial(e, phase(motion_, t)).cwiseProduct(omega + device_.gyr_bias);
        break;
      case EffectKind::kGyroBiasChange:
        if (lasts(e, 3, t)) gyr += e.vector();
        break;
      case EffectKind::kGyroGainChange:
        if (lasts(e, 3, t)) gyr += e.vector().cwiseProduct(omega + device_.gyr_bias);
        break;
      default:
        break;
    }
  }
  return gyr;
}

std::vector<Vector3d> ImuModel::acc() const {
  std::vector<Vector3d> readings;
  readings.reserve(t_.size());
  for (std::size_t k = 0; k + 1 < t_.size(); ++k) {
    readings.push_back(
        mean_about(t_[k] - acc_offset_, acc_mean_s_, [&](double t) { return acc_at(t); }));
  }
  for (const Effect& e : options_.effects) {
    if (e.kind == EffectKind::kAccHysteresis) stick(readings, e[0]);
  }
  return readings;
}

// The mean over every interval by Gauss's rule with three points, in parts of at most 10 ms.
std::vector<Vector3d> ImuModel::gyr() const {
  const double outer = std::sqrt(0.6);
  std::vector<Vector3d> readings;
  readings.reserve(t_.size());
  for (std::size_t k = 0; k + 1 < t_.size(); ++k) {
    const double dt = t_[k + 1] - t_[k];
    const int parts = std::max(1, static_cast<int>(std::ceil(dt / 0.0101)));
    const double half = 0.5 * dt / parts;
    Vector3d sum = Vector3d::Zero();
    for (int i = 0; i < parts; ++i) {
      const double middle = t_[k] + (2 * i + 1) * half;
      sum += 5.0 * (gyr_at(middle - outer * half) + gyr_at(middle + outer * half)) +
             8.0 * gyr_at(middle);
    }
    sum /= 18.0 * parts;
    readings.push_back(drift_.empty() ? sum : Vector3d(sum + drift_mean(k)));
  }
  return readings;
}

// d o_w = q d(beta). Over an interval h a Brownian motion's mean departs from that of its two ends
// by a normal of variance q^2 h / 12, whatever the ends.
void ImuModel::draw_drift(double q) {
  Random random(options_.seed, Stream::kBiasDrift);
  if (drift_.empty()) {
    drift_.assign(t_.size(), Vector3d::Zero());
    drift_bridge_.assign(t_.size(), Vector3d::Zero());
  }
  Vector3d drift = Vector3d::Zero();
  for (std::size_t k = 0; k + 1 < t_.size(); ++k) {
    const double step = q * std::sqrt(t_[k + 1] - t_[k]);
    drift += step * random.normal3();
    drift_[k + 1] += drift;
    drift_bridge_[k] += step / std::sqrt(12.0) * random.normal3();
  }
}

Vector3d ImuModel::drift_mean(std::size_t k) const {
  return 0.5 * (drift_[k] + drift_[k + 1]) + drift_bridge_[k];
}

void ImuModel::draw_taps(const Effect& e) {
  if (!(e[0] > 0.0)) return;
  Random random(options_.seed, Stream::kTapping);
  for (double t = 0.0;;) {
    t -= std::log(random.uniform()) / e[0];
    if (t >= t_.back()) return;
    const double size = e[1] * random.uniform(0.3, 1.0);
    taps_.push_back({t, size * random.direction()});
  }
}

}  // namespace magimu::oracle
