// SPDX-License-Identifier: BSD-3-Clause
// The field of a dipole at a place: the sensor passes by a magnet or a motor.
//   m(alpha) + B(p - place) / strength,  B = mu0 / (4 pi r^3) (3 u u' - I) moment,  u = (p - place)
//   / r
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "factors/effects/catalogue.h"

namespace magimu {

Vector3 dipole_field(const Vector3& moment, const Vector3& from_source) {
  constexpr double kMu0Over4Pi = 0.1;  // uT m / A
  const double r = from_source.norm();
  const Vector3 u = from_source / r;
  return kMu0Over4Pi / (r * r * r) * (3.0 * u * u.dot(moment) - moment);
}

namespace {

std::vector<Effect::Parameter> place_and_moment() {
  std::vector<Effect::Parameter> out = vector_parameters("place", "m", 1.0);
  for (const auto& p : vector_parameters("moment", "A m^2", 2.0)) out.push_back(p);
  return out;
}

class StationarySource final : public Effect {
 public:
  StationarySource()
      : Effect({.name = "stationary_source",
                .channel = Sensor::kMag,
                .parameters = place_and_moment(),
                .cause = "the sensor passes a magnet or iron that stays where it is",
                .needs = "pos",
                .separating_motion = "pass by the place again, in other orientations"}) {}

  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    constexpr double kStep = 1e-5;  // m
    const Vector3 place = theta.head<3>(), moment = theta.tail<3>();
    const Matrix3 seen = s.D * s.nRb.matrix().transpose() / s.strength_uT;
    for (int i = 0; i < 3; ++i) {
      const Vector3 e = kStep * Vector3::Unit(i);
      J.col(i) = seen *
                 (dipole_field(moment, s.position - place - e) -
                  dipole_field(moment, s.position - place + e)) /
                 (2.0 * kStep);
      J.col(3 + i) = seen * dipole_field(Vector3::Unit(i), s.position - place);
    }
  }
  Vector3 term(const SampleState& s, const VectorXd& theta) const override {
    const Vector3 place = theta.head<3>(), moment = theta.tail<3>();
    return s.D * s.nRb.unrotate(dipole_field(moment, s.position - place)) / s.strength_uT;
  }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    const double place = sigma.head<3>().norm();
    // Two figures of the uncertainty, down to a tenth of a millimetre.
    const int decimals = std::clamp(1 - int(std::floor(std::log10(std::max(place, 1e-9)))), 2, 4);
    return fmt::format(
        "The sensor passes a magnetic source at [{1:.{0}f}, {2:.{0}f}, {3:.{0}f}] m (+- {4:.{0}f} "
        "m) with a moment of {5:.2g} A m^2.",
        decimals, theta[0], theta[1], theta[2], place, theta.tail<3>().norm());
  }
};

class SourceAt final : public Effect {
 public:
  explicit SourceAt(const Vector3& place)
      : Effect({.name = "stationary_source",
                .channel = Sensor::kMag,
                .parameters = vector_parameters("moment", "A m^2", 2.0),
                .needs = "pos"}),
        place_(place) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    const Matrix3 seen = s.D * s.nRb.matrix().transpose() / s.strength_uT;
    for (int i = 0; i < 3; ++i) {
      J.col(i) = seen * dipole_field(Vector3::Unit(i), s.position - place_);
    }
  }

 private:
  Vector3 place_;
};

}  // namespace

std::shared_ptr<const Effect> make_stationary_source_at(const Vector3& place) {
  return std::make_shared<SourceAt>(place);
}

std::unique_ptr<Effect> make_stationary_source() { return std::make_unique<StationarySource>(); }

}  // namespace magimu
