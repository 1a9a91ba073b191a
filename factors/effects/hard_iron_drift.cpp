// SPDX-License-Identifier: BSD-3-Clause
// o_m + sum_j c_j P_j(u): the magnetometer's bias changes in time.
#include <fmt/format.h>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

std::vector<Effect::Parameter> drifts_of_hard_iron(int terms) {
  std::vector<Effect::Parameter> out;
  for (int j = 1; j <= terms; ++j) {
    for (const auto& p : vector_parameters(fmt::format("c[{}]", j), "uT", 3.0)) out.push_back(p);
  }
  return out;
}

class HardIronDrift final : public Effect {
 public:
  explicit HardIronDrift(int terms)
      : Effect({.name = "hard_iron_drift",
                .channel = Channel::kMag,
                .parameters = drifts_of_hard_iron(terms),
                .cause = "the magnetometer's bias changes with time",
                .separating_motion = "go through the same orientations early and late"}) {}

  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    for (int j = 1; 3 * j <= theta.size(); ++j) {
      J.middleCols<3>(3 * j - 3) = legendre(j, s.u) * Matrix3::Identity();
    }
  }
  std::shared_ptr<const Effect> with_terms(int terms) const override {
    return std::make_shared<HardIronDrift>(terms);
  }
};

}  // namespace

std::unique_ptr<Effect> make_hard_iron_drift() { return std::make_unique<HardIronDrift>(3); }

}  // namespace magimu
