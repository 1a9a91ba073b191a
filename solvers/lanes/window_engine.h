// SPDX-License-Identifier: BSD-3-Clause
// Least squares on chains + globals without a matrix of it all: windows of the trajectory are
// linearized and condensed in SIMD lanes and in parallel (lane_sweep.h), their boundaries and the
// globals are solved (boundary_chain.h), and a downward pass moves the nodes; in information or
// square-root form. Everything, the values included, stays in the lanes' order between iterations.
// Same bits for every number of threads; instruction sets differ by rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "solvers/lanes/boundary_chain.h"
#include "solvers/lanes/window_program.h"

namespace magimu {

class WindowEngine {
 public:
  // Null where the graph is not made of chains + globals, or too small to pay. isa: unless given,
  // the best of this machine. The graph must outlive the engine.
  static std::unique_ptr<WindowEngine> make(const FactorGraph& graph, const Values& values,
                                            std::optional<Isa> isa = std::nullopt,
                                            EliminationForm form = EliminationForm::kInformation);

  void load(const Values& values);
  void store(Values& values) const;

  // There are two sets of values: where the estimate is, and where a step leads. The cost where the
  // estimate is; all windows are linearized and condensed, damped in columns of unit norm.
  double condense(double damping);
  // Solves for the step of the boundaries and the globals. False where the problem is singular, or
  // too close to it for the form: Cholesky loses half of the digits of a problem's condition.
  bool solve();
  // Moves every variable by the step, into the second set, and linearizes and condenses there, in
  // one pass: the cost there. Then keep_candidate(), or condense() again.
  double advance(double damping);
  // The same where no step will be asked for: a look tells the cost there and the norms, but
  // nothing is condensed. After it, condense() comes before solve().
  double advance_and_look();
  void keep_candidate() { current_ = condensed_; }
  // |U'^-1 gradient| of all unknowns, after solve(): no less than the step's length in standard
  // deviations, and just that where nothing is damped.
  double longest_step_sigma() const { return std::sqrt(std::max(0.0, chain_->gained())); }

  double damping() const { return damping_; }  // at the last condense()
  double predicted_decrease() const { return predicted_; }
  double step_sigma() const { return sigma_; }
  double step_norm() const { return norm_; }
  double gradient_norm() const;  // in columns of unit norm
  // |value / sigma| of all variables together, 1 / sigma of a rotation.
  double sizes_in_sigmas() const;
  // Smallest pivot of the elimination relative to its diagonal (in the square-root form, of their
  // squares), after solve(): about the inverse of the condition number of J'J.
  double smallest_pivot() const { return pivot_; }
  EliminationForm form() const { return form_; }
  // Of the globals: information before elimination (diagonal), and what is left of it, inverted.
  const VectorXd& diagonal_globals() const { return chain_->diagonal_globals(); }
  MatrixXd covariance_globals() const { return chain_->covariance_globals(); }
  const lanes::Layout& layout() const { return layout_; }
  std::string describe() const;

 private:
  struct Group {
    double *nodes[2], *kept;  // current, proposed; in memory_
    AlignedBuffer left[2], out, delta_left, delta_right, sums;
  };
  WindowEngine(const FactorGraph& graph, const Values& values, lanes::Layout layout, Isa isa,
               EliminationForm form);
  struct Work {
    AlignedBuffer state, jacobian, panel;
  };
  lanes::Sweep sweep(std::size_t group, int set);
  // A pass over each group, upward from the set, with `before` it in the same task; then a window's
  // numbers are handed to the chain.
  enum class Pass { kCondense, kLook };
  template <class Before>
  double pass_over(Pass pass, int set, double damping, const Before& before);
  double advance(Pass pass, double damping);
  void move_boundaries();
  void add_globals(int set);

  const FactorGraph& graph_;
  Values layout_values_;  // for the slots
  lanes::Layout layout_;
  Isa isa_;
  EliminationForm form_;
  std::size_t lanes_;
  lanes::Program program_;
  lanes::Sizes sizes_;
  lanes::SweepCode code_;
  std::unique_ptr<lanes::BoundaryChain> chain_;
  std::vector<Group> groups_;
  AlignedBuffer memory_;  // most of it
  AlignedBuffer globals_[2];
  int condensed_ = 0;  // which set was condensed last
  int current_ = 0;
  double damping_ = 0.0, predicted_ = 0.0, sigma_ = 0.0, norm_ = 0.0, pivot_ = 1.0;
};

}  // namespace magimu
