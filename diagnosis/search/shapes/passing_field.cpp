// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/shapes/passing_field.h"

#include <fmt/format.h>

namespace magimu {
namespace {

constexpr int kShapes = 3;

class PassingField final : public Effect {
 public:
  PassingField(const ChangeSpan& span, bool beside_the_sensor)
      : Effect({.name = "passing_field",
                .channel = Sensor::kMag,
                .parameters = shapes(beside_the_sensor),
                .cause = "something magnetic came near and went again"}),
        span_(span),
        beside_the_sensor_(beside_the_sensor) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J.setZero();
    if (!span_.contains(s)) return;
    const double u = 2.0 * (s.t - span_.begin.t) / (span_.end.t - span_.begin.t) - 1.0;
    Matrix3 reads = Matrix3::Identity();
    if (!beside_the_sensor_) reads = s.D * s.nRb.matrix().transpose();
    for (int j = 0; j < kShapes; ++j) J.middleCols<3>(3 * j) = legendre(j, u) * reads;
  }

 private:
  static std::vector<Parameter> shapes(bool beside_the_sensor) {
    // As large as a magnet that is attached, or as what changes the field.
    const Parameter usual = find_effect(beside_the_sensor ? "hard_iron_change" : "field_change")
                                ->description()
                                .parameters.front();
    std::vector<Parameter> out;
    for (int j = 0; j < kShapes; ++j) {
      const auto own = vector_parameters(fmt::format("s{}", j), usual.unit, usual.prior_sigma);
      out.insert(out.end(), own.begin(), own.end());
    }
    return out;
  }

  ChangeSpan span_;
  bool beside_the_sensor_;
};

}  // namespace

std::shared_ptr<const Effect> make_passing_field(const ChangeSpan& span, bool beside_the_sensor) {
  return std::make_shared<PassingField>(span, beside_the_sensor);
}

}  // namespace magimu
