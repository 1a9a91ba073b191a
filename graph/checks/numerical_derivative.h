// SPDX-License-Identifier: BSD-3-Clause
// Jacobians of any factor by central differences through the variables' own retraction, and the
// comparison that every factor's test makes: analytic against numerical against automatic.
#pragma once

#include <string>

#include "graph/factor.h"
#include "graph/values.h"

namespace magimu {

// Pointers to the stored values of the factor's variables; invalidated when values changes.
template <class F>
Stored<F> stored_values(const F& factor, const Values& values) {
  Stored<F> x;
  for (std::size_t j = 0; j < x.size(); ++j) {
    x[j] = values.data().data() + values.slot(factor.keys()[j]).stored;
  }
  return x;
}

// d residual / d tangent (not whitened) by central differences with the given step.
template <class F>
JacobianOf<F> numerical_jacobian(const F& factor, const Values& values, double step = 1e-5) {
  JacobianOf<F> J;
  int column = 0;
  for (const Key key : factor.keys()) {
    const Values::Slot& slot = values.slot(key);
    for (int c = 0; c < slot.type.tangent(); ++c, ++column) {
      VectorXd delta = VectorXd::Zero(values.dim());
      delta[slot.tangent + c] = step;
      const Values plus = values.retract({delta.data(), std::size_t(delta.size())});
      delta[slot.tangent + c] = -step;
      const Values minus = values.retract({delta.data(), std::size_t(delta.size())});
      J.col(column) = (evaluate(factor, stored_values(factor, plus)) -
                       evaluate(factor, stored_values(factor, minus))) /
                      (2.0 * step);
    }
  }
  return J;
}

struct JacobianCheck {
  bool analytic = false;         // the factor has analytic Jacobians
  double numerical_error = 0.0;  // largest difference from central differences
  double automatic_error = 0.0;  // largest difference from automatic differentiation
  double residual_error = 0.0;   // largest difference of the residuals the two ways return
};

// Differences are relative to the largest entry of the Jacobian (of the residual), or absolute
// where that is below 1.
template <class F>
JacobianCheck check_jacobians(const F& factor, const Values& values) {
  const Stored<F> x = stored_values(factor, values);
  JacobianOf<F> given, automatic;
  const ResidualOf<F> r = linearize(factor, x, given);
  linearize_automatic(factor, x, automatic);
  const JacobianOf<F> numerical = numerical_jacobian(factor, values);
  const double scale = std::max(1.0, given.cwiseAbs().maxCoeff());
  const ResidualOf<F> e = evaluate(factor, x);
  return {detail::HasAnalyticJacobians<F>, (given - numerical).cwiseAbs().maxCoeff() / scale,
          (given - automatic).cwiseAbs().maxCoeff() / scale,
          (r - e).cwiseAbs().maxCoeff() / std::max(1.0, e.cwiseAbs().maxCoeff())};
}

}  // namespace magimu
