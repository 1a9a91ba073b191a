// SPDX-License-Identifier: BSD-3-Clause
// Turns and wandering as spline coefficients: draw_motion.h.
#include "tests/oracle/draw_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace magimu::oracle {
namespace {

using Coefficients = std::vector<Vector3d>;

constexpr double kTurnKnots = 0.35;    // s
constexpr double kWanderKnots = 0.15;  // s
constexpr double kFade = 1.5;          // s
constexpr int kReach = 3;              // knot intervals a coefficient acts on to each side
constexpr double kPi = std::numbers::pi;

double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10.0 - x * (15.0 - 6.0 * x));
}

std::size_t knot_count(const MotionOptions& o, double h) {
  return static_cast<std::size_t>(o.duration_s / h) + 2;
}

// The stretches of movement, s.
std::vector<std::pair<double, double>> stretches(const MotionOptions& o) {
  const double start = o.rest_s, end = o.duration_s - o.rest_s;
  if (end <= start) return {};
  if (o.pause_s <= 0.0) return {{start, end}};
  const double middle = 0.5 * (start + end), half = 0.5 * o.pause_s;
  return {{start, middle - half}, {middle + half, end}};
}

// How far inside a stretch of movement all of coefficient j's reach is, s; negative: not at all.
double depth(const std::vector<std::pair<double, double>>& moving, std::size_t j, double h) {
  const double t = static_cast<double>(j) * h;
  double deepest = -1.0;
  for (const auto& [start, end] : moving) {
    deepest = std::max(deepest, std::min(t - start, end - t) - kReach * h);
  }
  return deepest;
}

// Axes of turns: all of +-x, +-y, +-z in random order, each tilted, before any comes again.
class Axes {
 public:
  Vector3d next(const Vector3d& only, Random& random) {
    sign_ = -sign_;
    if (!only.isZero()) return sign_ * only.normalized();
    if (drawn_ % 6 == 0) {
      for (int i = 5; i > 0; --i) std::swap(order_[i], order_[random.index(i + 1)]);
    }
    const int axis = order_[drawn_++ % 6];
    Vector3d direction = 0.3 * random.normal3();
    direction[axis % 3] = axis < 3 ? 1.0 : -1.0;
    return direction.normalized();
  }

 private:
  std::array<int, 6> order_{0, 1, 2, 3, 4, 5};
  int drawn_ = 0;
  double sign_ = -1.0;
};

Coefficients wandering(const MotionOptions& o, double low_hz, double high_hz, Random& random) {
  constexpr int kTones = 24;
  const auto moving = stretches(o);
  Coefficients c(knot_count(o, kWanderKnots), Vector3d::Zero());
  for (int tone = 0; tone < kTones; ++tone) {
    for (int axis = 0; axis < 3; ++axis) {
      const double f = random.uniform(low_hz, high_hz);
      const double phase = random.uniform(0.0, 2.0 * kPi);
      for (std::size_t j = 0; j < c.size(); ++j) {
        c[j][axis] += std::cos(2.0 * kPi * f * kWanderKnots * static_cast<double>(j) + phase) / f;
      }
    }
  }
  for (std::size_t j = 0; j < c.size(); ++j) {
    const double inside = depth(moving, j, kWanderKnots);
    c[j] *= inside < 0.0 ? 0.0 : smooth_step((inside + kWanderKnots) / kFade);
  }
  return c;
}

// Norms of the curve at 20 ms, where it moves.
std::vector<double> norms(const MotionOptions& o, const Spline& curve) {
  std::vector<double> result;
  for (const auto& [start, end] : stretches(o)) {
    for (double t = start; t < end; t += 0.02) result.push_back(curve(t).norm());
  }
  return result;
}

}  // namespace

Spline draw_turns(const MotionOptions& o, const Vector3d& only, Random& random) {
  const auto moving = stretches(o);
  Coefficients c(knot_count(o, kTurnKnots), Vector3d::Zero());
  Axes axes;
  Vector3d rate = Vector3d::Zero();
  double until = -1.0;
  for (std::size_t j = 0; j < c.size(); ++j) {
    const double t = static_cast<double>(j) * kTurnKnots;
    if (t >= until) {  // the next turn: a third to a whole one, or as far as it gets in 15 s
      const double speed = o.fastest_rad_s * random.uniform(0.35, 0.9);
      rate = speed * axes.next(only, random);
      const double turn_s = random.uniform(0.35, 1.0) * 2.0 * kPi / speed;
      until = t + std::clamp(turn_s, 1.5, 15.0);
    }
    const Vector3d wobble = 0.05 * o.fastest_rad_s * random.normal3();
    if (depth(moving, j, kTurnKnots) >= 0.0) c[j] = only.isZero() ? Vector3d(rate + wobble) : rate;
  }
  return Spline(kTurnKnots, c);
}

namespace {

Spline bounded(const MotionOptions& o, double farthest, double low_hz, double high_hz,
               Random& random) {
  const Spline curve(kWanderKnots, wandering(o, low_hz, high_hz, random));
  const std::vector<double> n = norms(o, curve);
  const double most = n.empty() ? 0.0 : *std::max_element(n.begin(), n.end());
  return curve.scaled(most > 0.0 ? farthest / most : 0.0);
}

}  // namespace

Spline draw_bounded_turn(const MotionOptions& o, double farthest, Random& random) {
  return bounded(o, farthest, 0.1, 0.5, random);
}

Spline draw_heading(const MotionOptions& o, Random& random) {
  // The curve's length is that of three components, of which one is the heading.
  return bounded(o, std::sqrt(3.0) * 2.0 * kPi, 0.01, 0.08, random);
}

Spline draw_displacement(const MotionOptions& o, Random& random) {
  Coefficients c = wandering(o, o.band_hz[0], o.band_hz[1], random);
  double squares = 0.0;
  const std::vector<double> n = norms(o, Spline(kWanderKnots, c));
  for (const double x : n) squares += x * x;
  const double rms = n.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(n.size()));
  const Vector3d direction = random.direction();
  const auto moving = stretches(o);
  const double share = random.uniform(0.1, 0.9);
  if (moving.empty()) return {};
  const auto& [start, end] =
      moving[static_cast<std::size_t>(random.index(static_cast<int>(moving.size())))];
  const double whole = std::min(8.0, end - start - 1.0), way = 0.375 * whole;
  const double leave = start + 0.5 + share * (end - start - 1.0 - whole);
  for (std::size_t j = 0; j < c.size(); ++j) {
    const double t = static_cast<double>(j) * kWanderKnots - leave;
    c[j] *= rms > 0.0 ? o.displacement_m / rms : 0.0;
    if (depth(moving, j, kWanderKnots) < 0.0) continue;
    c[j] += o.carry_m * smooth_step(t / way) * smooth_step((whole - t) / way) * direction;
  }
  return Spline(kWanderKnots, c);
}

}  // namespace magimu::oracle
