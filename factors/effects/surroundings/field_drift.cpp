// SPDX-License-Identifier: BSD-3-Clause
// m(alpha) + sum_j c_j P_j(u): the field changes in time, as a fraction of it, in n.

#include "factors/effects/catalogue.h"
#include "factors/effects/drift.h"

namespace magimu {
namespace {

class FieldDrift final : public Effect {
 public:
  explicit FieldDrift(int terms)
      : Effect({.name = "field_drift",
                .channel = Sensor::kMag,
                .parameters = drift_parameters(terms, "1", 0.05),
                .cause = "the field of the place changes with time",
                .separating_motion = "go through the same orientations early and late"}) {}

  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    for (int j = 1; 3 * j <= theta.size(); ++j) {
      J.middleCols<3>(3 * j - 3) = legendre(j, s.u) * (s.D * s.nRb.matrix().transpose());
    }
  }
  std::shared_ptr<const Effect> with_terms(int terms) const override {
    return std::make_shared<FieldDrift>(terms);
  }
};

}  // namespace

std::unique_ptr<Effect> make_field_drift() { return std::make_unique<FieldDrift>(3); }

}  // namespace magimu
