// SPDX-License-Identifier: BSD-3-Clause
// mag + a cos(2 pi f t) + d sin(2 pi f t): the field of the mains, or of a motor, in the sensor's
// frame; f as the samples show it, folded about their rate. The frequency comes from a search
// (diagnosis/noise/noise_tests.h).
#include <fmt/format.h>

#include <cmath>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

std::vector<Effect::Parameter> amplitudes() {
  std::vector<Effect::Parameter> out = vector_parameters("a", "uT", 3.0);
  for (const auto& p : vector_parameters("d", "uT", 3.0)) out.push_back(p);
  return out;
}

class MainsInterference final : public Effect {
 public:
  explicit MainsInterference(double frequency_hz)
      : Effect({.name = "mains_interference",
                .channel = Channel::kMag,
                .parameters = amplitudes(),
                .cause = "an alternating field, of the mains or a motor, reaches the magnetometer",
                .separating_motion = "none is needed"}),
        frequency_hz_(frequency_hz) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    const double angle = 2.0 * M_PI * std::fmod(frequency_hz_ * s.t, 1.0);
    J << std::cos(angle) * Matrix3::Identity(), std::sin(angle) * Matrix3::Identity();
  }
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override {
    const double size = std::sqrt(theta.squaredNorm());
    const double error =
        std::sqrt((theta.cwiseProduct(sigma)).squaredNorm()) / std::max(size, 1e-12);
    return fmt::format(
        "An alternating field of {:.4f} Hz (as the samples show it; it may be a higher one, "
        "folded) "
        "reaches the magnetometer, amplitude {:.3g} +- {:.1g} uT.",
        frequency_hz_, size, error);
  }

 private:
  double frequency_hz_;
};

}  // namespace

std::unique_ptr<Effect> make_mains_interference() {
  return std::make_unique<MainsInterference>(50.0);
}

std::shared_ptr<const Effect> make_mains_at(double frequency_hz) {
  return std::make_shared<MainsInterference>(frequency_hz);
}

}  // namespace magimu
