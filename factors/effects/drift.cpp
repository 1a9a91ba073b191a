// SPDX-License-Identifier: BSD-3-Clause
#include "factors/effects/drift.h"

#include <fmt/format.h>

namespace magimu {
namespace {

Effect::Description with_parameters(Effect::Description description,
                                    std::vector<Effect::Parameter> parameters) {
  description.parameters = std::move(parameters);
  return description;
}

// A part's gain changes by some hundredths of a per cent a kelvin.
constexpr double kUsualGain = 0.02;

// k_first to k_terms.
std::vector<Effect::Parameter> gain_parameters(int terms, int first) {
  std::vector<Effect::Parameter> out;
  for (int j = first; j <= terms; ++j) {
    for (const auto& p : vector_parameters(fmt::format("k[{}]", j), "1", kUsualGain)) {
      out.push_back(p);
    }
  }
  return out;
}

Vector3 reading_of(const SampleState& s, Channel channel) {
  if (channel == Channel::kAcc) return s.f + s.bias;
  if (channel == Channel::kGyr) return s.omega + s.bias;
  return s.D * s.b + s.bias;
}

}  // namespace

std::vector<Effect::Parameter> drift_parameters(int terms, const std::string& unit,
                                                double prior_sigma) {
  std::vector<Effect::Parameter> out;
  for (int j = 1; j <= terms; ++j) {
    for (const auto& p : vector_parameters(fmt::format("c[{}]", j), unit, prior_sigma)) {
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
    : Effect(with_parameters(description, gain_parameters(terms, first))), first_(first) {}

void GainDrift::jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const {
  const Vector3 reading = reading_of(s, channel());
  for (int j = 0; 3 * j < theta.size(); ++j) {
    J.middleCols<3>(3 * j) = legendre(j + first_, s.u) * Matrix3(reading.asDiagonal());
  }
}

std::shared_ptr<const Effect> GainDrift::with_terms(int terms) const {
  return std::make_shared<GainDrift>(description(), terms, first_);
}

}  // namespace magimu
