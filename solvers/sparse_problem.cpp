// SPDX-License-Identifier: BSD-3-Clause
// An optimizer's problem as one sparse linear system and a back end, for any graph; and the choice
// between this and windows in SIMD lanes (optimizer_problem.h).
#include <cmath>
#include <stdexcept>

#include "solvers/back_ends.h"
#include "solvers/linear/optimizer_problem.h"

namespace magimu {
namespace {

class SparseProblem final : public OptimizerProblem {
 public:
  SparseProblem(const FactorGraph& graph, const Values& values, const OptimizerOptions& options)
      : by_largest_(options.damp_by_largest_norm),
        system_(graph, values),
        solver_(make_linear_solver(options.backend)) {
    linearize(values);
  }

  double cost() const override { return cost_; }
  bool is_finite() const override {
    return std::isfinite(cost_) && system_.residual().allFinite() && norms_.allFinite();
  }
  bool is_flat() const override { return rows() > 0 && norms_.size() > 0 && !norms_.any(); }
  double gradient_norm() const override { return scale_.cwiseProduct(system_.gradient()).norm(); }
  // Column norm times value, of all variables together: by how much the residuals would change if
  // each variable changed by its own size.
  double sizes_in_sigmas() const override {
    VectorXd out = norms_;
    for (const Values::Slot& s : values_.slots()) {
      if (s.type.kind == 'R') continue;  // the size of a rotation is 1
      for (int i = 0; i < s.type.tangent(); ++i) {
        out[s.tangent + i] *= std::abs(values_.data()[std::size_t(s.stored + i)]);
      }
    }
    return out.norm();
  }
  int rows() const override { return system_.rows(); }

  bool solve(double damping) override {
    const VectorXd& scale = by_largest_ ? largest_scale_ : scale_;
    if (!solver_->factorize(system_, scale, damping)) return false;
    const VectorXd delta = scale.cwiseProduct(solver_->solve(system_, scale));
    const VectorXd Jd = system_.multiply(delta);
    step_.damping = damping;
    step_.predicted_decrease = -(system_.residual().dot(Jd) + 0.5 * Jd.squaredNorm());
    step_.sigma = Jd.norm();
    step_.norm = delta.norm();
    candidate_ = values_.retract({delta.data(), std::size_t(delta.size())});
    return delta.allFinite();
  }
  double try_step(ProposedStep& step, double) override {
    step = step_;
    return system_.cost(candidate_);
  }
  void accept() override { linearize(std::move(candidate_)); }
  void go_back(const Values& values, double) override { linearize(values); }
  Values values() const override { return values_; }
  const VectorXd& norms() const override { return norms_; }
  const VectorXd& largest_norms() const override { return largest_; }
  std::string solver() const override { return to_string(solver_->backend()); }

 private:
  void linearize(Values values) {
    values_ = std::move(values);
    cost_ = system_.linearize(values_);
    norms_ = system_.squared_column_norms().cwiseSqrt();
    if (largest_.size() == 0) largest_ = norms_;
    largest_ = largest_.cwiseMax(norms_);
    const auto inverse = [](double n) { return n > 0.0 ? 1.0 / n : 1.0; };
    scale_ = norms_.unaryExpr(inverse);
    largest_scale_ = largest_.unaryExpr(inverse);
  }

  bool by_largest_;
  LinearSystem system_;
  std::unique_ptr<LinearSolver> solver_;
  Values values_, candidate_;
  ProposedStep step_;
  VectorXd norms_, largest_;        // of the columns: now, and at most so far
  VectorXd scale_, largest_scale_;  // their inverses
  double cost_ = 0.0;
};

}  // namespace

std::unique_ptr<OptimizerProblem> make_sparse_problem(const FactorGraph& graph,
                                                      const Values& values,
                                                      const OptimizerOptions& options) {
  return std::make_unique<SparseProblem>(graph, values, options);
}

std::unique_ptr<OptimizerProblem> make_problem(const FactorGraph& graph, const Values& values,
                                               const OptimizerOptions& options) {
  const bool asked = options.backend == Backend::kWindows;
  if ((asked || options.backend == Backend::kAuto) && !options.damp_by_largest_norm) {
    if (auto windows = make_window_problem(graph, values, options)) return windows;
  }
  if (asked) {
    throw std::invalid_argument(
        "the graph is not made of long chains that share a few globals (or has robust losses), so "
        "windows cannot serve; use Backend::kAuto");
  }
  OptimizerOptions chosen = options;
  if (options.backend == Backend::kAuto && options.form == EliminationForm::kSquareRoot) {
    chosen.backend = square_root_backend();
  }
  return make_sparse_problem(graph, values, chosen);
}

}  // namespace magimu
