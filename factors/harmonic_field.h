// SPDX-License-Identifier: BSD-3-Clause
// A field that differs from place to place, as an effect on the magnetometer's readings: about the
// middle of the sensor's path a sum of gradients of harmonic polynomials (field_basis.h), beside
// the constant ones,
//
//   mag = D R' (m + sum_i c_i Phi_i((p - middle) / reach) / strength) + o_m
//
// with p the position that a fit of a hand-held sensor estimates, or that was measured. It has the
// name of the finding, field_departure, and is no effect of the catalogue: nothing is known of it
// before its order and surroundings are.
#pragma once

#include <memory>
#include <vector>

#include "factors/effects/effect.h"

namespace magimu {

// Of one recording; positions as its fit has them.
struct HarmonicField {
  Vector3 middle = Vector3::Zero();  // n, m
  double reach_m = 1.0;
  VectorXd size_uT;  // prior standard deviation of each c, as many as the order has
};

// sum_i c_i Phi_i, uT in n, at a place, m.
Vector3 field_uT(const HarmonicField& field, int order, const VectorXd& c, const Vector3& place);

// Of recordings that follow each other as SampleState::recording counts them; its parameters are
// their coefficients c, uT, one recording after the other. order: 1 to FieldBasis::kHighestOrder.
std::shared_ptr<const Effect> make_harmonic_field(int order, std::vector<HarmonicField> fields);

}  // namespace magimu
