// SPDX-License-Identifier: BSD-3-Clause
// The effects on the magnetometer, one equation each: mag_model.h.
#include "tests/oracle/mag_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/oracle/random.h"

namespace magimu::oracle {
namespace {

constexpr double kFilterStep = 1e-3;      // s
constexpr double kReferenceField = 50.0;  // uT
constexpr double kTurn = 0.3;             // rad/s: slower ones leave things where they are

Matrix3d symmetric_traceless(const Effect& e) {
  Matrix3d g;
  g << e[0], e[2], e[3], e[2], e[1], e[4], e[3], e[4], -e[0] - e[1];
  return g;
}

}  // namespace

Vector3d dipole_field_uT(const Vector3d& moment, const Vector3d& from_source) {
  const double r = from_source.norm();
  const Vector3d u = from_source / r;
  return 0.1 / (r * r * r) * (3.0 * u * u.dot(moment) - moment);  // mu0 / (4 pi) = 0.1 uT m / A
}

double motor_current(double t, double hz) {
  return 1.0 + 2.0 * std::exp(-t / 0.3) + 0.3 * std::sin(2.0 * std::numbers::pi * hz * t);
}

Vector3d relax(const Vector3d& s, const Vector3d& h0, const Vector3d& h1, double x) {
  const double left = std::exp(-x);
  return h1 - (h1 - h0) * (-std::expm1(-x) / x) + (s - h0) * left;
}

MagModel::MagModel(const Options& options, const Device& device, const Motion& motion,
                   const std::vector<double>& true_t)
    : options_(options), device_(device), motion_(motion), t_(true_t) {
  for (const double t : t_) {
    mean_temperature_ += options.temperature(t) / static_cast<double>(t_.size());
    mean_p_ += motion.position(t) / static_cast<double>(t_.size());
  }
  if (options.room_seed) {
    room_.emplace(*options.room_seed, device.unit_field(), motion.duration_s());
  }
  Random jitter(options.seed, Stream::kTimeJitter);
  for (const Effect& e : options.effects) {
    if (e.kind == EffectKind::kMagTimeOffset) offset_ += e[0];
    if (e.kind == EffectKind::kMagAxisTimeOffset) axis_offset_ += e.vector();
    if (e.kind == EffectKind::kMagLag) lag_ += e[0];
    if (e.kind == EffectKind::kMagBandwidth) mean_s_ += std::sqrt(12.0 * e[0]);
    if (e.kind == EffectKind::kMagTimeJitter) {
      for (double& t : t_) t += e[0] * jitter.normal();
    }
    if (e.kind == EffectKind::kMagOwnClock && e[0] > 0.0) {
      for (double& t : t_) t -= e[0] * (t / e[0] + e[1] - std::floor(t / e[0] + e[1]));
    }
  }
}

Vector3d MagModel::field(const Instant& at) const {
  const double strength = device_.strength_uT();
  Vector3d m = device_.unit_field();
  if (room_) m += room_->field_uT(at.p, at.t) / strength;
  for (const Effect& e : options_.effects) {
    switch (e.kind) {
      case EffectKind::kFieldDrift:
        m += polynomial(e, phase(motion_, at.t));
        break;
      case EffectKind::kFieldChange:
        if (lasts(e, 3, at.t)) m += e.vector();
        break;
      case EffectKind::kFieldGradient:
        m += symmetric_traceless(e) * (at.p - mean_p_) / strength;
        break;
      case EffectKind::kStationarySource:
        m += dipole_field_uT(e.vector(3), at.p - e.vector()) / strength;
        break;
      case EffectKind::kPassingPhone: {
        const Vector3d phone = e.vector(3) + (at.t - e[9]) * e.vector(6);
        m += dipole_field_uT(e.vector(0), at.p - phone) / strength;
        break;
      }
      default:
        break;
    }
  }
  return at.bRn * m;
}

Vector3d MagModel::hard_iron(const Instant& at) const {
  Vector3d o_m = device_.mag_bias;
  for (const Effect& e : options_.effects) {
    switch (e.kind) {
      case EffectKind::kMagTemperature:
        o_m += e.vector() * (options_.temperature(at.t) - mean_temperature_);
        break;
      case EffectKind::kHardIronDrift:
        o_m += polynomial(e, phase(motion_, at.t));
        break;
      case EffectKind::kHardIronChange:
        if (at.t >= e[3] && at.t < e[4]) o_m += e.vector();
        break;
      case EffectKind::kCableField: {
        const Matrix3d turned = instant(motion_, options_.gravity, 0.0).bRn * at.bRn.transpose();
        o_m += e.vector() * (1.0 - 0.5 * (turned.trace() - 1.0));
        break;
      }
      default:
        break;
    }
  }
  return o_m;
}

Vector3d MagModel::h(double t) const {
  const Instant at = instant(motion_, options_.gravity, t);
  return device_.distortion * field(at) + hard_iron(at);
}

Vector3d MagModel::reading_terms(const Instant& at) const {
  const Vector3d b = field(at), B = device_.distortion * b;
  Vector3d sum = Vector3d::Zero();
  for (const Effect& e : options_.effects) {
    switch (e.kind) {
      case EffectKind::kMagEddyCurrent:
        sum += e.matrix() * at.omega.cross(b);
        break;
      case EffectKind::kMagNonlinearity:
        sum.array() += e.vector().array() * B.array().cube() / (kReferenceField * kReferenceField);
        break;
      case EffectKind::kMagCurrent:
        sum += e.vector() * options_.current(at.t);
        break;
      case EffectKind::kMainsInterference: {
        const double angle = 2.0 * std::numbers::pi * e[6] * at.t;
        sum += e.vector(0) * std::cos(angle) + e.vector(3) * std::sin(angle);
        break;
      }
      case EffectKind::kMagGainChange:
        if (lasts(e, 3, at.t)) sum += e.vector().cwiseProduct(B + hard_iron(at));
        break;
      case EffectKind::kMagGainDrift:
        sum += polynomial(e, phase(motion_, at.t)).cwiseProduct(B + hard_iron(at));
        break;
      case EffectKind::kMagChange:
        if (lasts(e, 9, at.t)) sum += first_matrix(e) * (B + hard_iron(at));
        break;
      case EffectKind::kSoftIronChange:
        if (lasts(e, 9, at.t)) sum += first_matrix(e) * b;
        break;
      case EffectKind::kMagBoardTurn:
        if (lasts(e, 3, at.t)) {
          const Vector3d h_at = B + hard_iron(at);
          sum += exp_so3(e.vector()) * h_at - h_at;
        }
        break;
      case EffectKind::kMotorCurrent:
        if (lasts(e, 4, at.t)) sum += e.vector() * motor_current(at.t - e[4], e[3]);
        break;
      case EffectKind::kMovingSoftIron:
        sum += at.f.z() / at.f.norm() * (e.matrix() * b);
        break;
      case EffectKind::kMagCrossAxis:
        sum.array() += e.vector().array() / kReferenceField *
                       Vector3d(B.y(), B.z(), B.x()).array() *
                       Vector3d(B.z(), B.x(), B.y()).array();
        break;
      default:
        break;
    }
  }
  return sum;
}

std::vector<Vector3d> MagModel::h_before(double offset) const {
  std::vector<double> sensed_t = t_;
  for (double& t : sensed_t) t -= offset;
  if (lag_ > 0.0) return lagged(sensed_t, lag_);
  std::vector<Vector3d> result;
  for (const double t : sensed_t) {
    result.push_back(mean_about(t, mean_s_, [&](double at) { return h(at); }));
  }
  return result;
}

std::vector<Vector3d> MagModel::readings() const {
  std::vector<Vector3d> result = h_before(offset_ + axis_offset_.x());
  if (axis_offset_ != Vector3d::Constant(axis_offset_.x())) {
    const std::vector<Vector3d> y = h_before(offset_ + axis_offset_.y()),
                                z = h_before(offset_ + axis_offset_.z());
    for (std::size_t k = 0; k < t_.size(); ++k) result[k].tail<2>() << y[k].y(), z[k].z();
  }
  for (std::size_t k = 0; k < t_.size(); ++k) {
    result[k] += reading_terms(instant(motion_, options_.gravity, t_[k]));
  }
  for (const Effect& e : options_.effects) {
    if (e.kind == EffectKind::kMagMemory) add_memory(result, e[0], e[1]);
    if (e.kind == EffectKind::kSecondDevice) mix(result, e);
    if (e.kind == EffectKind::kLastTurnOffset) add_last_turn(result, e);
    if (e.kind == EffectKind::kMagHysteresis) stick(result, e[0]);
  }
  return result;
}

// From rest at the start, in steps of at most 1 ms between samples. A time before that of the
// sample before it (jitter) gets that sample's value.
std::vector<Vector3d> MagModel::lagged(const std::vector<double>& t, double lag) const {
  std::vector<Vector3d> result;
  double now = std::min(0.0, t.front());
  Vector3d h_now = h(now), s = h_now;
  for (const double until : t) {
    const int steps = std::max(0, static_cast<int>(std::ceil((until - now) / kFilterStep - 1e-9)));
    const double dt = steps > 0 ? (until - now) / steps : 0.0;
    for (int i = 1; i <= steps; ++i) {
      const Vector3d h_next = h(now + dt * i);
      s = relax(s, h_now, h_next, dt / lag);
      h_now = h_next;
    }
    if (steps > 0) now = until;
    result.push_back(s);
  }
  return result;
}

void MagModel::mix(std::vector<Vector3d>& readings, const Effect& e) const {
  const auto every = static_cast<std::size_t>(std::max(1.0, e[12]));
  for (std::size_t k = 0; k < readings.size(); k += every) {
    if (!lasts(e, 13, t_[k])) continue;
    const Vector3d b = field(instant(motion_, options_.gravity, t_[k]));
    readings[k] += first_matrix(e) * b + e.vector(9);
  }
}

// The rate is looked at every kFilterStep.
void MagModel::add_last_turn(std::vector<Vector3d>& readings, const Effect& e) const {
  const Vector3d axis = e.vector(3).normalized();
  double now = 0.0, sign = 0.0;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    for (; now <= t_[k]; now += kFilterStep) {
      const double rate = motion_.omega(now).dot(axis);
      if (std::abs(rate) > kTurn) sign = rate > 0.0 ? 1.0 : -1.0;
    }
    readings[k] += sign * e.vector();
  }
}

void MagModel::add_memory(std::vector<Vector3d>& readings, double chi, double relaxation_s) const {
  Vector3d before, s;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const Vector3d now =
        chi * (device_.distortion * field(instant(motion_, options_.gravity, t_[k])));
    const double dt = k > 0 ? t_[k] - t_[k - 1] : 0.0;
    s = k == 0 ? now : dt > 0.0 ? relax(s, before, now, dt / relaxation_s) : s;
    before = now;
    readings[k] += s;
  }
}

}  // namespace magimu::oracle
