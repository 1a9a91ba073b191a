// SPDX-License-Identifier: BSD-3-Clause
// The paper's motion, and the step from continuous rates to a gyroscope's mean rates: motion.h.
#include "sim/motions/motion.h"

#include <array>
#include <cmath>

#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kNominalRate = 0.1;   // rad/s, about each axis that takes part
constexpr double kRateJitter = 0.05;   // rad/s, standard deviation of each component in every step
constexpr double kLongestStep = 1e-3;  // s, of the integration

const std::array<Vector3, 6>& paper_axes() {
  static const std::array<Vector3, 6> axes{Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1),
                                           Vector3(1, 1, 0), Vector3(1, 0, 1), Vector3(0, 1, 1)};
  return axes;
}

double turn_duration_s(const Vector3& axis) {
  return 2.0 * RandomStream::kPi / (kNominalRate * axis.norm());
}

Vector3 paper_nominal_rate(double t_moving) {
  double t = std::fmod(t_moving, paper_motion_duration_s());
  for (const Vector3& axis : paper_axes()) {
    if (t < turn_duration_s(axis)) return kNominalRate * axis;
    t -= turn_duration_s(axis);
  }
  return kNominalRate * paper_axes().back();  // rounding at the very end
}

// The rotation over [t, t + h]: R(t + h) = R(t) Exp(phi). With the rates w1, w2 at the two Gauss
// points, phi = h/2 (w1 + w2) + sqrt(3)/12 h^2 w1 x w2 + O(h^5) (Iserles et al., Acta Numerica
// 2000, section 5, for a rate that multiplies from the right).
Rot3 magnus_step(const std::function<Vector3(double)>& omega, double t, double h) {
  const double offset = std::sqrt(3.0) / 6.0;
  const Vector3 w1 = omega(t + (0.5 - offset) * h);
  const Vector3 w2 = omega(t + (0.5 + offset) * h);
  return Rot3::Exp(0.5 * h * (w1 + w2) + std::sqrt(3.0) / 12.0 * h * h * w1.cross(w2));
}

}  // namespace

std::size_t sample_count(double duration_s, double rate_hz) {
  return static_cast<std::size_t>(std::llround(duration_s * rate_hz));
}

std::vector<Rot3> integrate(const AngularMotion& motion, double rate_hz) {
  std::vector<Rot3> nRb;
  nRb.reserve(motion.mean_rate.size());
  Rot3 R = motion.initial_nRb;
  for (const Vector3& rate : motion.mean_rate) {
    nRb.push_back(R);
    // At rest not a bit may change, and renormalizing can change the last.
    if (!rate.isZero(0.0)) R = (R * Rot3::Exp(rate / rate_hz)).normalized();
  }
  return nRb;
}

double paper_motion_duration_s() {
  double duration = 0.0;
  for (const Vector3& axis : paper_axes()) duration += turn_duration_s(axis);
  return duration;
}

AngularMotion paper_motion(std::uint64_t seed, double rate_hz, double duration_s, double rest_s) {
  RandomStream random(seed, RandomPurpose::kMotion);
  const std::size_t count = sample_count(duration_s, rate_hz);
  const std::size_t resting = sample_count(rest_s, rate_hz);
  AngularMotion motion;
  motion.mean_rate.assign(count, Vector3::Zero());
  for (std::size_t k = resting; k < count; ++k) {
    const double t_moving = static_cast<double>(k - resting) / rate_hz;
    motion.mean_rate[k] = paper_nominal_rate(t_moving) + kRateJitter * random.normal3();
  }
  return motion;
}

AngularMotion sample_motion(const Rot3& initial_nRb, const std::function<Vector3(double)>& omega,
                            double rate_hz, double duration_s) {
  const int steps = static_cast<int>(std::ceil(1.0 / (rate_hz * kLongestStep)));
  const double h = 1.0 / (rate_hz * steps);
  AngularMotion motion{initial_nRb, {}};
  motion.mean_rate.resize(sample_count(duration_s, rate_hz));
  for (std::size_t k = 0; k < motion.mean_rate.size(); ++k) {
    const double t = static_cast<double>(k) / rate_hz;
    Rot3 turned;
    for (int i = 0; i < steps; ++i) turned = turned * magnus_step(omega, t + i * h, h);
    motion.mean_rate[k] = turned.Log() * rate_hz;
  }
  return motion;
}

Rot3 turn_between(const std::function<Vector3(double)>& omega, double t0, double t1) {
  const int steps = std::max(1, static_cast<int>(std::ceil((t1 - t0) / kLongestStep - 1e-9)));
  const double h = (t1 - t0) / steps;
  Rot3 turned;
  for (int i = 0; i < steps; ++i) turned = turned * magnus_step(omega, t0 + i * h, h);
  return turned;
}

}  // namespace magimu
