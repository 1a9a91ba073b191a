// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "solvers/lanes/window_engine.h"
#include "solvers/linear/optimizer_problem.h"

namespace magimu {
namespace {

// One pass linearizes and condenses; after a step it gives the cost there and all that the next
// step needs, so that an accepted step costs one pass.
class WindowProblem final : public OptimizerProblem {
 public:
  WindowProblem(std::unique_ptr<WindowEngine> engine, const FactorGraph& graph,
                const Values& values, const OptimizerOptions& options)
      : graph_(graph), options_(options), engine_(std::move(engine)), values_(values) {
    engine_->load(values);
    cost_ = engine_->condense(options.initial_damping);
    here_ = true;
    for (const auto& batch : graph.batches()) rows_ += batch->rows() * batch->size();
    watch();
  }

  double cost() const override { return cost_; }
  bool is_finite() const override { return std::isfinite(cost_) && norms_.allFinite(); }
  double gradient_norm() const override { return gradient_norm_; }
  double sizes_in_sigmas() const override { return sizes_; }
  int rows() const override { return rows_; }

  bool solve(double damping) override {
    const double before = engine_->damping();
    const bool light = before <= damping && damping <= kLightDamping;
    if (!here_ || !(light || before == damping)) {
      engine_->condense(damping);
      here_ = true;
    }
    if (engine_->solve()) return true;
    if (engine_->form() == EliminationForm::kSquareRoot || options_.form || !is_finite())
      return false;
    // Close to singular: reflections of the Jacobian itself, from here on.
    const Values at = values();
    engine_ = WindowEngine::make(graph_, at, options_.isa, EliminationForm::kSquareRoot);
    engine_->load(at);
    cost_ = engine_->condense(damping);
    return engine_->solve();
  }
  double try_step(ProposedStep& step, double last_sigma) override {
    here_ = false;
    looked_ = engine_->longest_step_sigma() < last_sigma;
    step.damping = engine_->damping();
    // As Levenberg-Marquardt will ask where the step turns out as predicted.
    const double next = kFastestDecrease * engine_->damping();
    candidate_cost_ = looked_ ? engine_->advance_and_look()
                              : engine_->advance(next < options_.min_damping ? 0.0 : next);
    step.predicted_decrease = engine_->predicted_decrease();
    step.sigma = engine_->step_sigma();
    step.norm = engine_->step_norm();
    return candidate_cost_;
  }
  void accept() override {
    here_ = !looked_;
    cost_ = candidate_cost_;
    engine_->keep_candidate();
    watch();
  }
  void go_back(const Values& values, double damping) override {
    engine_->load(values);
    cost_ = engine_->condense(damping);
    here_ = true;
    watch();
  }
  Values values() const override {
    Values out = values_;
    engine_->store(out);
    return out;
  }
  const VectorXd& norms() const override { return norms_; }
  const VectorXd& largest_norms() const override { return largest_; }
  std::string solver() const override { return engine_->describe(); }

 private:
  // What is known from the last pass only; norms of the globals' columns.
  void watch() {
    gradient_norm_ = engine_->gradient_norm();
    sizes_ = engine_->sizes_in_sigmas();
    if (norms_.size() == 0) norms_ = largest_ = VectorXd::Zero(values_.dim());
    const auto& variables = engine_->layout().variables;
    for (std::size_t s = 0; s < variables.size(); ++s) {
      if (variables[s].node >= 0) continue;
      const Values::Slot& slot = values_.slots()[s];
      for (int c = 0; c < slot.type.tangent(); ++c) {
        norms_[slot.tangent + c] = std::sqrt(engine_->diagonal_globals()[variables[s].tangent + c]);
      }
    }
    largest_ = largest_.cwiseMax(norms_);
  }

  const FactorGraph& graph_;
  OptimizerOptions options_;
  std::unique_ptr<WindowEngine> engine_;
  Values values_;  // the layout
  VectorXd norms_, largest_;
  double cost_ = 0.0, candidate_cost_ = 0.0, gradient_norm_ = 0.0, sizes_ = 0.0;
  bool here_ = false;    // was the engine's last pass where we stand, and did it condense?
  bool looked_ = false;  // was it but a look?
  int rows_ = 0;
};

}  // namespace

std::unique_ptr<OptimizerProblem> make_window_problem(const FactorGraph& graph,
                                                      const Values& values,
                                                      const OptimizerOptions& options) {
  auto engine = WindowEngine::make(graph, values, options.isa,
                                   options.form.value_or(EliminationForm::kInformation));
  if (!engine) return nullptr;
  return std::make_unique<WindowProblem>(std::move(engine), graph, values, options);
}

}  // namespace magimu
