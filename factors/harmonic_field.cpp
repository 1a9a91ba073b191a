// SPDX-License-Identifier: BSD-3-Clause
#include "factors/harmonic_field.h"

#include <fmt/format.h>

#include "factors/field_basis.h"

namespace magimu {
namespace {

std::vector<Effect::Parameter> coefficients_of(const std::vector<HarmonicField>& fields) {
  std::vector<Effect::Parameter> out;
  for (std::size_t r = 0; r < fields.size(); ++r) {
    const std::string name = fields.size() > 1 ? fmt::format("c[{}]", r) : "c";
    for (Eigen::Index i = 0; i < fields[r].size_uT.size(); ++i) {
      out.push_back({fmt::format("{}[{}]", name, i), "uT", fields[r].size_uT[i]});
    }
  }
  return out;
}

class HarmonicFields final : public Effect {
 public:
  HarmonicFields(int order, std::vector<HarmonicField> fields)
      : Effect({.name = "field_departure",
                .channel = Sensor::kMag,
                .parameters = coefficients_of(fields),
                .cause = "the field differs from place to place",
                .separating_motion = "visit different places in the same orientation",
                .proper_prior = true,
                .of_position = true}),
        basis_(order),
        fields_(std::move(fields)) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J.setZero();
    const auto r = std::size_t(s.recording);
    if (r >= fields_.size()) return;
    const HarmonicField& field = fields_[r];
    const Eigen::Index n = field.size_uT.size();
    const Matrix3X phi = basis_.at(Vector3((s.position - field.middle) / field.reach_m));
    J.middleCols(Eigen::Index(r) * n, n) =
        s.D * s.nRb.matrix().transpose() * phi.rightCols(n) / s.strength_uT;
  }

  Matrix3 by_position(const SampleState& s, const VectorXd& c) const override {
    const auto r = std::size_t(s.recording);
    if (r >= fields_.size()) return Matrix3::Zero();
    const HarmonicField& field = fields_[r];
    const Eigen::Index n = field.size_uT.size();
    VectorXd all = VectorXd::Zero(basis_.size());
    all.tail(n) = c.segment(Eigen::Index(r) * n, n);
    const Vector3 from_middle = (s.position - field.middle) / field.reach_m;
    return s.D * s.nRb.matrix().transpose() * basis_.gradient(all, from_middle) /
           (field.reach_m * s.strength_uT);
  }

 private:
  FieldBasis basis_;
  std::vector<HarmonicField> fields_;
};

}  // namespace

Vector3 field_uT(const HarmonicField& field, int order, const VectorXd& c, const Vector3& place) {
  return FieldBasis(order).at(Vector3((place - field.middle) / field.reach_m)).rightCols(c.size()) *
         c;
}

std::shared_ptr<const Effect> make_harmonic_field(int order, std::vector<HarmonicField> fields) {
  return std::make_shared<HarmonicFields>(order, std::move(fields));
}

}  // namespace magimu
