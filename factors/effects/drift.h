// SPDX-License-Identifier: BSD-3-Clause
// What changes slowly with time: sums of Legendre polynomials P_j(u) over the recording.
#pragma once

#include <string>
#include <vector>

#include "factors/effects/effect.h"

namespace magimu {

// c_first to c_terms, three numbers each: "c[1][0]" and so on, or with another letter.
std::vector<Effect::Parameter> drift_parameters(int terms, const std::string& unit,
                                                double prior_sigma, const char* letter = "c",
                                                int first = 1);

// A sensor's bias + sum_j c_j P_j(u).
class BiasDrift final : public Effect {
 public:
  // description: but for the parameters, whose unit and prior are those of each c_j.
  BiasDrift(const Description& description, int terms, const std::string& unit, double prior_sigma);

  void jacobian(const SampleState& state, const VectorXd& theta, EffectJacobian J) const override;
  std::shared_ptr<const Effect> with_terms(int terms) const override;
};

// A sensor's gains change: sum_j k_j,i P_j(u) times all that the axis i reads, its bias too, j up
// to the number of terms; from 1 on, or from 0 where no other parameter has the gain itself.
class GainDrift final : public Effect {
 public:
  GainDrift(const Description& description, int terms, int first = 1);

  void jacobian(const SampleState& state, const VectorXd& theta, EffectJacobian J) const override;
  std::shared_ptr<const Effect> with_terms(int terms) const override;

 private:
  int first_;
};

}  // namespace magimu
