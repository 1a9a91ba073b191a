// SPDX-License-Identifier: BSD-3-Clause
#include "factors/effects/drift.h"

#include <fmt/format.h>

#include "factors/effects/own_reading.h"

namespace magimu {
namespace {

Effect::Description with_parameters(Effect::Description description,
                                    std::vector<Effect::Parameter> parameters) {
  description.parameters = std::move(parameters);
  return description;
}

// A part's gain changes by some hundredths of a per cent a kelvin.
constexpr double kUsualGain = 0.02;

}  // namespace

std::vector<Effect::Parameter> drift_parameters(int terms, const std::string& unit,
                                                double prior_sigma, const char* letter, int first) {
  std::vector<Effect::Parameter> out;
  for (int j = first; j <= terms; ++j) {
    for (const auto& p : vector_parameters(fmt::format("{}[{}]", letter, j), unit, prior_sigma)) {
      out.push_back(p);
    }
  }
  return out;
}

BiasDrift::BiasDrift(const Description& description, int terms, const std::string& unit,
                     double prior_sigma)
    : Effect(with_parameters(description, drift_parameters(terms, unit, prior_sigma))) {}

void BiasDrift::jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const {
  for (int j = 1; 3 * j <= theta.size(); ++j) {
    J.middleCols<3>(3 * j - 3) = legendre(j, s.u) * Matrix3::Identity();
  }
}

std::shared_ptr<const Effect> BiasDrift::with_terms(int terms) const {
  const Parameter& of_each = description().parameters.front();
  return std::make_shared<BiasDrift>(description(), terms, of_each.unit, of_each.prior_sigma);
}

GainDrift::GainDrift(const Description& description, int terms, int first)
    : Effect(with_parameters(description, drift_parameters(terms, "1", kUsualGain, "k", first))),
      first_(first) {}

void GainDrift::jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const {
  const Vector3 reading = own_reading(s, channel());
  for (int j = 0; 3 * j < theta.size(); ++j) {
    J.middleCols<3>(3 * j) = legendre(j + first_, s.u) * Matrix3(reading.asDiagonal());
  }
}

std::shared_ptr<const Effect> GainDrift::with_terms(int terms) const {
  return std::make_shared<GainDrift>(description(), terms, first_);
}

}  // namespace magimu
