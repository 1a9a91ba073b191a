// SPDX-License-Identifier: BSD-3-Clause
// g0 + d: gravity here is not the one that the model has. The sensor reads the difference upwards,
// R' (0, 0, d). Where it only turns that is a scale error of all axes alike, L = d / g0 I.
#include <fmt/format.h>

#include <cmath>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

// m/s^2: between the places on Earth where it differs most (9.764 on a high mountain near the
// equator, 9.834 at a pole), and usual.
constexpr double kLargest = 0.07, kUsual = 9.80665;

class Gravity final : public Effect {
 public:
  Gravity()
      : Effect({.name = "gravity",
                .channel = Sensor::kAcc,
                // At sea level it is 9.780 at the equator and 9.832 at the poles.
                .parameters = {{"d", "m/s^2", 0.02}},
                .cause = "gravity here is not the one that was assumed",
                .separating_motion = "hold every face of the sensor up in turn"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J = s.nRb.unrotate(Vector3::UnitZ());
  }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    if (std::abs(theta[0]) - 3.0 * sigma[0] > kLargest) {
      return fmt::format(
          "All gains of the accelerometer are off alike: it reads {:.2f} % too {}, gravity {:.4f} "
          "+- {:.4f} m/s^2 {} than the one assumed, which at no place on Earth it is.",
          100.0 * std::abs(theta[0]) / kUsual, theta[0] < 0.0 ? "little" : "much",
          std::abs(theta[0]), sigma[0], theta[0] < 0.0 ? "less" : "more");
    }
    return fmt::format(
        "Gravity here is {} than the one assumed by {:.4f} +- {:.4f} m/s^2 (--gravity and "
        "--location set it), or all gains of the accelerometer are off alike.",
        theta[0] < 0.0 ? "less" : "more", std::abs(theta[0]), sigma[0]);
  }
};

}  // namespace

std::unique_ptr<Effect> make_gravity() { return std::make_unique<Gravity>(); }

}  // namespace magimu
