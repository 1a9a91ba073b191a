// SPDX-License-Identifier: BSD-3-Clause
// acc = f(t - tau) + o_a: the accelerometer shows what was tau seconds ago, against the gyroscope.
// Half a sample is a convention: which time a sample is given.
#include <fmt/format.h>

#include <cmath>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class AccTimeOffset final : public Effect {
 public:
  AccTimeOffset()
      : Effect({.name = "acc_time_offset",
                .channel = Sensor::kAcc,
                .parameters = {{"tau", "s", 0.02}},
                .cause = "the accelerometer lags the gyroscope",
                .separating_motion = "turn fast, and start and stop abruptly"}) {}

  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    constexpr double kStep = 2e-4;  // s: the force bends little within, and rounding is far below
    J = (s.force_change(theta[0] + kStep) - s.force_change(theta[0] - kStep)) / (2.0 * kStep);
  }
  Vector3 term(const SampleState& s, const VectorXd& theta) const override {
    return s.force_change(theta[0]);
  }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    return fmt::format("The accelerometer {} the gyroscope by {:.2f} +- {:.2f} ms.",
                       theta[0] < 0.0 ? "is ahead of" : "lags", 1e3 * std::abs(theta[0]),
                       1e3 * sigma[0]);
  }
};

}  // namespace

std::unique_ptr<Effect> make_acc_time_offset() { return std::make_unique<AccTimeOffset>(); }

}  // namespace magimu
