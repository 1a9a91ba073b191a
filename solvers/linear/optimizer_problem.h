// SPDX-License-Identifier: BSD-3-Clause
// What an optimizer sees of a graph: the present values, a damped step from there, and the cost
// after the step. Two ways of doing the same: a sparse system and a linear back end (any graph),
// or windows in SIMD lanes (chains + globals, window_engine.h).
#pragma once

#include <memory>
#include <string>

#include "graph/factor_graph.h"
#include "solvers/linear/optimizer_options.h"

namespace magimu {

struct ProposedStep {
  double damping = 0.0;             // that it was computed with
  double predicted_decrease = 0.0;  // of the undamped quadratic model
  double sigma = 0.0;               // its length in standard deviations
  double norm = 0.0;                // |delta|, mixed units
};

// Least factor by which Levenberg-Marquardt lowers the damping after a step that went as predicted.
inline constexpr double kFastestDecrease = 0.01;
// Damping up to this leaves a step's length about what it would be without.
inline constexpr double kLightDamping = 1e-4;

class OptimizerProblem {
 public:
  virtual ~OptimizerProblem() = default;

  virtual double cost() const = 0;  // at the present values
  // Are the residuals and Jacobians there finite numbers?
  virtual bool is_finite() const = 0;
  virtual double gradient_norm() const = 0;  // in columns of unit norm
  // No residual depends on any variable there: robust losses have left all factors out, or the
  // residuals are flat.
  virtual bool is_flat() const { return false; }
  // |value / sigma| of all variables together, 1 / sigma of a rotation.
  virtual double sizes_in_sigmas() const = 0;
  virtual int rows() const = 0;
  // Solves for a step with this damping (a light one may be lighter still); false if the matrix is
  // singular.
  virtual bool solve(double damping) = 0;
  // The step, and the cost after it; then either accept() or another solve(). A step shorter than
  // last_sigma standard deviations is the last: what another one would need may wait.
  virtual double try_step(ProposedStep& step, double last_sigma) = 0;
  virtual void accept() = 0;
  // Back to values where it has been, to be solved with this damping.
  virtual void go_back(const Values& values, double damping) = 0;
  virtual Values values() const = 0;
  // Norms of the columns at the present values, and the largest that they have had; 0 for columns
  // that are not watched.
  virtual const VectorXd& norms() const = 0;
  virtual const VectorXd& largest_norms() const = 0;
  // The name of what solves for the steps, for people.
  virtual std::string solver() const = 0;
};

// Throws std::invalid_argument if the back end cannot serve the graph.
std::unique_ptr<OptimizerProblem> make_problem(const FactorGraph& graph, const Values& values,
                                               const OptimizerOptions& options);
std::unique_ptr<OptimizerProblem> make_sparse_problem(const FactorGraph& graph,
                                                      const Values& values,
                                                      const OptimizerOptions& options);
// Null where the graph is not of that form.
std::unique_ptr<OptimizerProblem> make_window_problem(const FactorGraph& graph,
                                                      const Values& values,
                                                      const OptimizerOptions& options);

}  // namespace magimu
