// SPDX-License-Identifier: BSD-3-Clause
// o_m + s for t0 <= t < t1: a magnet is attached or removed. The times come from a search
// (diagnosis/change_search.h); s is what the graph estimates.
#include <fmt/format.h>

#include <limits>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

class HardIronChange final : public Effect {
 public:
  HardIronChange(double t0, double t1)
      : Effect({.name = "hard_iron_change",
                .channel = Channel::kMag,
                .parameters = vector_parameters("s", "uT", 20.0),
                .cause = "a magnet was attached to the device or removed from it",
                .separating_motion = "turn through the same orientations before and after"}),
        t0_(t0),
        t1_(t1) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J = (s.t >= t0_ && s.t < t1_ ? 1.0 : 0.0) * Matrix3::Identity();
  }
  std::string sentence(const VectorXd& s, const VectorXd& sigma) const override {
    std::string when;
    if (std::isinf(t0_)) {
      when = fmt::format("was attached from the start and removed at {:.2f} s", t1_);
    } else if (std::isinf(t1_)) {
      when = fmt::format("was attached or removed at {:.2f} s", t0_);
    } else {
      when = fmt::format("was attached or removed at {:.2f} s and again at {:.2f} s", t0_, t1_);
    }
    return fmt::format(
        "A magnet (or a piece of iron) {}: the magnetometer's bias was different by "
        "[{:.2f}, {:.2f}, {:.2f}] +- [{:.2f}, {:.2f}, {:.2f}] uT.",
        when, s[0], s[1], s[2], sigma[0], sigma[1], sigma[2]);
  }

 private:
  double t0_, t1_;
};

}  // namespace

std::unique_ptr<Effect> make_hard_iron_change() {
  return std::make_unique<HardIronChange>(0.0, std::numeric_limits<double>::infinity());
}

std::shared_ptr<const Effect> make_hard_iron_change_between(double t0, double t1) {
  return std::make_shared<HardIronChange>(t0, t1);
}

}  // namespace magimu
