// SPDX-License-Identifier: BSD-3-Clause
// gyr = (I + S) omega + o_w.
#include <fmt/format.h>

#include "factors/effects/catalogue.h"
#include "factors/effects/turn_words.h"

namespace magimu {
namespace {

class GyroScaleMisalignment final : public Effect {
 public:
  GyroScaleMisalignment()
      : Effect({.name = "gyro_scale_misalignment",
                .channel = Sensor::kGyr,
                .parameters = matrix_parameters("S", "1", 0.02),
                .cause = "the gyroscope's axes have scale errors or are not those of the IMU",
                .contains = {"clock_scale"},
                .separating_motion = "turn by several full turns about each axis in turn"}) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    matrix_jacobian(s.omega, J);
  }

  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    using Rows = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
    const Matrix3 M = Matrix3::Identity() + Matrix3(Rows(theta.data()));
    const auto turn = turn_and_rest(M, Rows(sigma.data()));
    if (!turn || !is_mostly_a_turn(*turn)) return Effect::sentence(theta, sigma);
    return fmt::format(
        "The gyroscope is {} against the accelerometer, whose axes are the IMU's; beside that its "
        "gains and the angles between its axes differ by up to {:.2g} %.",
        turned_words(*turn), 100.0 * std::max(turn->rest, std::abs(turn->scale - 1.0)));
  }
};

}  // namespace

std::unique_ptr<Effect> make_gyro_scale_misalignment() {
  return std::make_unique<GyroScaleMisalignment>();
}

}  // namespace magimu
