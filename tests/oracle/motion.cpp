// SPDX-License-Identifier: BSD-3-Clause
// Kinematics of a drawn motion: motion.h.
#include "tests/oracle/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/oracle/draw_motion.h"

namespace magimu::oracle {
namespace {

constexpr double kGrid = 1e-3;  // s

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

bool turns_freely(MotionKind kind) {
  return kind == MotionKind::kRotation || kind == MotionKind::kHandHeld ||
         kind == MotionKind::kOneAxis;
}

// Any heading, within 10 deg of level.
Quaterniond draw_attitude(Random& random) {
  const double heading = random.uniform(0.0, 2.0 * std::numbers::pi);
  const double about = random.uniform(0.0, 2.0 * std::numbers::pi);
  const double tilt = random.uniform(0.0, 10.0 * kDegree);
  return exp_so3(Vector3d(0, 0, heading)) *
         exp_so3(tilt * Vector3d(std::cos(about), std::sin(about), 0.0));
}

}  // namespace

std::string to_string(MotionKind kind) {
  switch (kind) {
    case MotionKind::kRotation:
      return "rotation";
    case MotionKind::kHandHeld:
      return "hand_held";
    case MotionKind::kOneAxis:
      return "one_axis";
    case MotionKind::kTranslation:
      return "translation";
    case MotionKind::kShortTurn:
      return "short_turn";
    case MotionKind::kStill:
      return "still";
    case MotionKind::kLevel:
      return "level";
  }
  return "unknown";
}

Quaterniond exp_so3(const Vector3d& v) {
  const double angle = v.norm();
  // sin(x / 2) / x, by its series where x^4 vanishes beside 1
  const double s = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  return {std::cos(0.5 * angle), s * v.x(), s * v.y(), s * v.z()};
}

Matrix3d right_jacobian_so3(const Vector3d& v) {
  const double x2 = v.squaredNorm(), x = std::sqrt(x2);
  const bool small = x < 0.02;
  const double a = small ? 0.5 - x2 / 24.0 + x2 * x2 / 720.0 : (1.0 - std::cos(x)) / x2;
  const double b = small ? 1.0 / 6.0 - x2 / 120.0 + x2 * x2 / 5040.0 : (x - std::sin(x)) / (x2 * x);
  const Matrix3d c = cross_matrix(v);
  return Matrix3d::Identity() - a * c + b * c * c;
}

Motion::Motion(const MotionOptions& options, std::uint64_t seed) : options_(options) {
  Random random(seed, Stream::kMotion);
  const Quaterniond start = draw_attitude(random);
  const Vector3d axis = options.axis.isZero() ? random.direction() : options.axis;
  const MotionKind kind = options.kind;
  Random turning(seed, Stream::kMotion, 1), moving(seed, Stream::kMotion, 2);
  if (turns_freely(kind)) {
    rate_ = draw_turns(options, kind == MotionKind::kOneAxis ? axis : Vector3d::Zero(), turning);
  } else if (kind != MotionKind::kStill) {
    const double usual = kind == MotionKind::kTranslation ? 8.0
                         : kind == MotionKind::kLevel     ? 10.0
                                                          : 35.0;
    const double farthest = options.farthest_turn_deg > 0.0 ? options.farthest_turn_deg : usual;
    angle_ = draw_bounded_turn(options, farthest * kDegree, turning);
    if (kind == MotionKind::kLevel) heading_ = draw_heading(options, turning);
  }
  if (kind == MotionKind::kHandHeld || kind == MotionKind::kTranslation) {
    displacement_ = draw_displacement(options, moving);
  }
  grid_.push_back(start);
  if (rate_.empty()) return;
  const auto steps = static_cast<std::size_t>(std::ceil(options.duration_s / kGrid));
  grid_.reserve(steps + 1);
  for (std::size_t i = 0; i < steps; ++i) {
    const Vector3d step = turn(static_cast<double>(i) * kGrid, kGrid);
    grid_.push_back(step.isZero(0.0) ? grid_.back() : (grid_.back() * exp_so3(step)).normalized());
  }
}

Vector3d Motion::omega(double t) const {
  if (angle_.empty()) return rate_(t);
  const Vector3d own = right_jacobian_so3(angle_(t)) * angle_(t, 1);
  if (heading_.empty()) return own;
  const Quaterniond level = grid_.front() * exp_so3(angle_(t));
  return own + level.conjugate() * Vector3d(0, 0, heading_(t, 1).z());
}

Vector3d Motion::angular_acceleration(double t) const {
  if (angle_.empty()) return rate_(t, 1);
  constexpr double h = 2e-3;  // the error of this quotient is of order h^4: 1e-9 of the value
  return (8.0 * (omega(t + h) - omega(t - h)) - (omega(t + 2 * h) - omega(t - 2 * h))) / (12.0 * h);
}

// Omega_4 of Blanes et al. 2009 for R' = R [omega]: the two Gauss points, and half a commutator.
Vector3d Motion::turn(double t, double h) const {
  const double offset = std::sqrt(3.0) / 6.0;
  const Vector3d first = rate_(t + (0.5 - offset) * h), second = rate_(t + (0.5 + offset) * h);
  return 0.5 * h * (first + second) + std::sqrt(3.0) / 12.0 * h * h * first.cross(second);
}

Quaterniond Motion::nRb(double t) const {
  if (!angle_.empty()) {
    const Quaterniond turned = grid_.front() * exp_so3(angle_(t));
    return heading_.empty() ? turned : exp_so3(Vector3d(0, 0, heading_(t).z())) * turned;
  }
  const double x = std::clamp(t / kGrid, 0.0, static_cast<double>(grid_.size() - 1));
  const auto i = static_cast<std::size_t>(x);
  const double rest = (x - static_cast<double>(i)) * kGrid;
  const Vector3d step = turn(static_cast<double>(i) * kGrid, rest);
  return step.isZero(0.0) ? grid_[i] : (grid_[i] * exp_so3(step)).normalized();
}

}  // namespace magimu::oracle
