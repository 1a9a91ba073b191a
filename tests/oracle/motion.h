// SPDX-License-Identifier: BSD-3-Clause
// How the oracle's sensor moves: smooth functions of continuous time, drawn from a seed. The body
// rate omega(t) and the position p(t) are closed forms (spline.h), with velocity and acceleration
// their exact derivatives; the attitude solves R' = R [omega] on a grid of 1 ms by the Magnus
// method of fourth order and, between its points, by one more such step, so that R is known at any
// time to rounding (a step's error is below 1e-15). Bounded turns are the other way round: the
// attitude is the closed form and the rate follows. In the rests omega, v and a are exactly 0.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "tests/oracle/spline.h"

namespace magimu::oracle {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kDegree = std::numbers::pi / 180.0;

enum class MotionKind {
  kRotation,     // turned on the spot about all its axes, both ways
  kHandHeld,     // the same, and moved about
  kOneAxis,      // turned about one body axis only, to and fro
  kTranslation,  // moved about, hardly turned
  kShortTurn,    // turned on the spot about all axes, but only a little
  kStill,        // lies where it is
  kLevel,        // stays about level and turns about the vertical, as a boat or a car does
};
std::string to_string(MotionKind kind);  // "rotation", "hand_held", ...

struct MotionOptions {
  MotionKind kind = MotionKind::kRotation;
  double duration_s = 120.0;  // all rests included
  double rest_s = 3.0;        // at the start and again at the end
  double pause_s = 2.0;       // a rest in the middle; 0: none
  // |omega| hardly exceeds it, rad/s: kRotation, kHandHeld, kOneAxis. A usual hand: 2.5.
  double fastest_rad_s = 2.5;
  // The farthest from the attitude at the start, deg: kTranslation, kShortTurn; kLevel:
  // roll and pitch. 0: 8, 35 and 10.
  double farthest_turn_deg = 0.0;
  // Body axis of kOneAxis; zero: a random one.
  Vector3d axis = Vector3d::Zero();
  // Root mean square of |p| while moving, m: kHandHeld, kTranslation.
  double displacement_m = 0.10;
  double band_hz[2] = {0.3, 1.5};  // of the displacement
  // Besides: once carried that far in a random direction and back, within about 8 s, m.
  double carry_m = 0.0;
};

class Motion {
 public:
  Motion(const MotionOptions& options, std::uint64_t seed);

  double duration_s() const { return options_.duration_s; }
  const MotionOptions& options() const { return options_; }

  // Before 0 and after the end it rests.
  Vector3d omega(double t) const;                 // body frame, rad/s
  Vector3d angular_acceleration(double t) const;  // d omega / dt
  Quaterniond nRb(double t) const;
  Vector3d position(double t) const { return displacement_(t); }  // n, m; 0 at the start
  Vector3d velocity(double t) const { return displacement_(t, 1); }
  Vector3d acceleration(double t) const { return displacement_(t, 2); }

 private:
  // The attitude's step from t to t + h where rate_ leads it: body frame, rad.
  Vector3d turn(double t, double h) const;

  MotionOptions options_;
  Spline rate_;     // omega, or
  Spline angle_;    // phi with R(t) = R(0) Exp(phi(t)), for motions whose turn is bounded
  Spline heading_;  // of kLevel, rad: R(t) = Rz(heading) R(0) Exp(phi(t)), in z; else empty
  Spline displacement_;
  std::vector<Quaterniond> grid_;  // at 0, 1 ms, 2 ms, ...; R(0) alone where rate_ does not lead
};

// Exp and the right Jacobian of SO(3), R Exp(v + dv) = R Exp(v) Exp(J dv), by Rodrigues' formula.
Quaterniond exp_so3(const Vector3d& v);
Matrix3d right_jacobian_so3(const Vector3d& v);

}  // namespace magimu::oracle
