// SPDX-License-Identifier: BSD-3-Clause
// mag_i = h_i(t - tau_i): one converter measures the magnetometer's axes one after another.
#include <fmt/format.h>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class MagAxisTimeOffset final : public Effect {
 public:
  MagAxisTimeOffset()
      : Effect({.name = "mag_axis_time_offset",
                .channel = Sensor::kMag,
                .parameters = vector_parameters("tau", "s", 0.05),
                .cause = "the magnetometer measures its axes one after another",
                .contains = {"mag_time_offset", "mag_lag"},
                .separating_motion = "turn fast about each axis in turn"}) {}

  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    J.setZero();
    for (int i = 0; i < 3; ++i) J(i, i) = s.D.row(i).dot(s.omega.cross(s.field_before(theta[i])));
  }
  Vector3 term(const SampleState& s, const VectorXd& theta) const override {
    Vector3 out;
    for (int i = 0; i < 3; ++i) out[i] = s.D.row(i).dot(s.field_before(theta[i]) - s.b);
    return out;
  }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    const auto axis = [&](int i) {
      return fmt::format("{:.2f} +- {:.2f} ms", 1e3 * theta[i], 1e3 * sigma[i]);
    };
    return fmt::format(
        "The magnetometer measures its axes one after another: x lags the gyroscope by {}, y by "
        "{}, z by {}.",
        axis(0), axis(1), axis(2));
  }
};

}  // namespace

std::unique_ptr<Effect> make_mag_axis_time_offset() {
  return std::make_unique<MagAxisTimeOffset>();
}

}  // namespace magimu
