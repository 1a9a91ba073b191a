// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/shapes/passing_field.h"

#include <fmt/format.h>

namespace magimu {
namespace {

constexpr int kShapes = 3;

class PassingField final : public Effect {
 public:
  explicit PassingField(const ChangeSpan& span)
      : Effect({.name = "passing_field",
                .channel = Sensor::kMag,
                .parameters = shapes(),
                .cause = "something magnetic came near and went again"}),
        span_(span) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J.setZero();
    if (!span_.contains(s)) return;
    const double u = 2.0 * (s.t - span_.begin.t) / (span_.end.t - span_.begin.t) - 1.0;
    for (int j = 0; j < kShapes; ++j) {
      J.middleCols<3>(3 * j) = legendre(j, u) * Matrix3::Identity();
    }
  }

 private:
  static std::vector<Parameter> shapes() {
    // As large as a magnet that is attached.
    const double sigma =
        find_effect("hard_iron_change")->description().parameters.front().prior_sigma;
    std::vector<Parameter> out;
    for (int j = 0; j < kShapes; ++j) {
      const auto own = vector_parameters(fmt::format("s{}", j), "uT", sigma);
      out.insert(out.end(), own.begin(), own.end());
    }
    return out;
  }

  ChangeSpan span_;
};

}  // namespace

std::shared_ptr<const Effect> make_passing_field(const ChangeSpan& span) {
  return std::make_shared<PassingField>(span);
}

}  // namespace magimu
