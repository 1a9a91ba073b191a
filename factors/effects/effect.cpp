// SPDX-License-Identifier: BSD-3-Clause
#include "factors/effects/effect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

constexpr double kClear = 2.0;  // standard deviations, of a number that says something by itself

}  // namespace

Vector3 Effect::term(const SampleState& state, const VectorXd& theta) const {
  Eigen::Matrix<double, 3, Eigen::Dynamic> J(3, theta.size());
  jacobian(state, theta, J);
  return J * theta;
}

Matrix3 Effect::by_position(const SampleState&, const VectorXd&) const { return Matrix3::Zero(); }

VectorXd Effect::prior_sigma(double) const {
  VectorXd sigma(size());
  for (int i = 0; i < size(); ++i) sigma[i] = description_.parameters[std::size_t(i)].prior_sigma;
  return sigma;
}

std::shared_ptr<const Effect> Effect::with_terms(int) const { return nullptr; }

std::string Effect::sentence(const VectorXd& theta, const VectorXd& sigma) const {
  std::string first = description_.cause;
  if (!first.empty()) first[0] = char(std::toupper(first[0]));
  std::string values;
  // Of many numbers the one that stands out most; the others are in the table.
  int most = 0;
  for (int i = 0; i < size(); ++i) {
    const auto clear = [&](int k) { return std::abs(theta[k]) / std::max(sigma[k], 1e-300); };
    if (clear(i) > clear(most)) most = i;
  }
  const bool few = size() <= 3;
  if (!few) values = "clearest ";
  if (!few && std::abs(theta[most]) < kClear * sigma[most]) {
    return fmt::format("{}: by {} numbers that are known together and not one by one.", first,
                       size());
  }
  for (int i = few ? 0 : most; i < (few ? size() : most + 1); ++i) {
    const Parameter& p = description_.parameters[std::size_t(i)];
    values += fmt::format("{}{} = {:.3g} +- {:.1g}{}{}", few && i > 0 ? ", " : "", p.name, theta[i],
                          sigma[i], p.unit == "1" ? "" : " ", p.unit == "1" ? "" : p.unit);
  }
  return first + ": " + values + ".";
}

const std::vector<std::shared_ptr<const Effect>>& effect_catalogue() {
  static const std::vector<std::shared_ptr<const Effect>> all = make_catalogue();
  return all;
}

std::shared_ptr<const Effect> find_effect(const std::string& name) {
  for (const auto& effect : effect_catalogue()) {
    if (effect->name() == name) return effect;
  }
  return nullptr;
}

double legendre(int j, double u) {
  double before = 1.0, now = u;
  if (j == 0) return before;
  for (int n = 1; n < j; ++n) {
    const double next = ((2.0 * n + 1.0) * u * now - n * before) / (n + 1.0);
    before = now;
    now = next;
  }
  return now;
}

std::vector<Effect::Parameter> vector_parameters(const std::string& name, const std::string& unit,
                                                 double prior_sigma) {
  std::vector<Effect::Parameter> out;
  for (int i = 0; i < 3; ++i) out.push_back({fmt::format("{}[{}]", name, i), unit, prior_sigma});
  return out;
}

std::vector<Effect::Parameter> matrix_parameters(const std::string& name, const std::string& unit,
                                                 double prior_sigma) {
  std::vector<Effect::Parameter> out;
  for (int i = 0; i < 9; ++i) {
    out.push_back({fmt::format("{}[{}][{}]", name, i / 3, i % 3), unit, prior_sigma});
  }
  return out;
}

void matrix_jacobian(const Vector3& x, EffectJacobian J) {
  J.setZero();
  for (int i = 0; i < 3; ++i) J.row(i).segment<3>(3 * i) = x.transpose();
}

}  // namespace magimu
