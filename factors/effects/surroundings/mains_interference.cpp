// SPDX-License-Identifier: BSD-3-Clause
// mag + a cos(2 pi f t) + d sin(2 pi f t): the field of the mains, or of a motor; f as the samples
// show it, folded about their rate. The frequency comes from a search
// (diagnosis/noise/noise_tests.h). a and d are in the sensor's frame, where a cable or a motor is
// fixed to it, or in n, where the room makes the field: then D / strength R' times that.
#include <fmt/format.h>

#include <cmath>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

std::vector<Effect::Parameter> amplitudes(bool of_room) {
  std::vector<Effect::Parameter> out = vector_parameters(of_room ? "a_n" : "a", "uT", 3.0);
  for (const auto& p : vector_parameters(of_room ? "d_n" : "d", "uT", 3.0)) out.push_back(p);
  return out;
}

class MainsInterference final : public Effect {
 public:
  MainsInterference(double frequency_hz, bool of_room)
      : Effect({.name = "mains_interference",
                .channel = Sensor::kMag,
                .parameters = amplitudes(of_room),
                .cause = "an alternating field, of the mains or a motor, reaches the magnetometer",
                .separating_motion = "none is needed"}),
        frequency_hz_(frequency_hz),
        of_room_(of_room) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    const double angle = 2.0 * M_PI * std::fmod(frequency_hz_ * s.t, 1.0);
    Matrix3 in_sensor = Matrix3::Identity();
    if (of_room_) in_sensor = s.D / s.strength_uT * s.nRb.matrix().transpose();
    J << std::cos(angle) * in_sensor, std::sin(angle) * in_sensor;
  }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    const double size = std::sqrt(theta.squaredNorm());
    const double error =
        std::sqrt((theta.cwiseProduct(sigma)).squaredNorm()) / std::max(size, 1e-12);
    return fmt::format(
        "An alternating field of {:.4f} Hz (as the samples show it; it may be a higher one, "
        "folded) "
        "reaches the magnetometer, amplitude {:.3g} +- {:.1g} uT; it {}.",
        frequency_hz_, size, error,
        of_room_ ? "is the room's, and does not turn with the sensor" : "turns with the sensor");
  }

 private:
  double frequency_hz_;
  bool of_room_;
};

}  // namespace

std::unique_ptr<Effect> make_mains_interference() {
  return std::make_unique<MainsInterference>(50.0, false);
}

std::shared_ptr<const Effect> make_mains_at(double frequency_hz, bool of_room) {
  return std::make_shared<MainsInterference>(frequency_hz, of_room);
}

}  // namespace magimu
