// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/levenberg_marquardt.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "graph/checks/not_finite.h"
#include "graph/numerical_error.h"
#include "solvers/back_ends.h"
#include "solvers/linear/optimizer_problem.h"
#include "solvers/null_space.h"

namespace magimu {
namespace {

// Steps after one that rose that may bring the cost below where that one began. Each has to lower
// it.
constexpr int kStepsDown = 4;
constexpr int kMaxRises = 5;  // rising costs in a row after which Gauss-Newton gives up
// The cost is known to about this relative precision: its sum has rounding errors.
constexpr double kCostPrecision = 1e-12;
// Variables are held to about this relative precision, and so is what the residuals make of them.
constexpr double kVariablePrecision = 4.0 * std::numeric_limits<double>::epsilon();

constexpr const char* kNotFiniteMessage = "A residual or a Jacobian is not a finite number";

using Step = ProposedStep;

// Options that mean nothing.
void check(const OptimizerOptions& o) {
  const auto need = [](bool right, const char* what) {
    if (!right) throw std::invalid_argument(std::string("OptimizerOptions::") + what);
  };
  need(o.step_tolerance >= 0.0, "step_tolerance is in standard deviations, not negative");
  need(o.max_iterations >= 0, "max_iterations is not negative");
  need(o.initial_damping >= 0.0, "initial_damping is not negative");
  need(o.min_damping >= 0.0, "min_damping is not negative");
  need(o.max_damping >= o.min_damping, "max_damping is no less than min_damping");
  need(o.min_gain_ratio >= 0.0, "min_gain_ratio is not negative");
}

class Run {
 public:
  Run(const FactorGraph& graph, const OptimizerOptions& options, const Values& initial)
      : graph_(graph),
        options_(options),
        start_(std::chrono::steady_clock::now()),
        columns_(initial.dim()),
        problem_((check(options), make_problem(graph, initial, options))) {
    result_.cost_initial = cost();
    result_.values = initial;
    find_rounding();
  }

  bool linearization_is_finite() const { return problem_->is_finite(); }
  bool start_is_finite() {
    if (std::isfinite(cost())) return true;
    stop_not_finite("The residuals at the initial values are not finite numbers");
    return false;
  }

  bool solve(double damping) { return problem_->solve(damping); }
  double try_step(Step& step, double damping) {
    return problem_->try_step(step, damping <= kLightDamping ? small_sigma() : 0.0);
  }
  void accept() {
    problem_->accept();
    find_rounding();
  }
  // Where the steps of an excursion began, to go back to.
  void set_out() { base_ = problem_->values(); }
  void go_back(double damping) {
    problem_->go_back(base_, damping);
    find_rounding();
  }
  double cost() const { return problem_->cost(); }
  // Is a change of the cost no larger than its rounding errors?
  bool negligible(double change) const {
    return std::abs(change) <=
           std::max(kCostPrecision * cost(), std::sqrt(2.0 * cost()) * variables_rounding_);
  }
  // Is a step that damping hardly shortened small enough to stop?
  bool small(const Step& step) const { return step.sigma < small_sigma(); }
  // One standard deviation, in units of the factors' noise.
  double sigma_unit() const {
    if (!options_.noise_from_residuals || problem_->rows() <= columns_) return 1.0;
    return std::sqrt(2.0 * cost() / (problem_->rows() - columns_));
  }

  void record(const Step& step, double gain_ratio, bool accepted, double gradient_norm) {
    result_.trace.push_back({int(result_.trace.size()), cost(), gradient_norm, step.norm,
                             step.sigma, step.damping, gain_ratio, accepted});
    result_.step_norm = step.norm;
  }
  double gradient_norm() const { return problem_->gradient_norm(); }
  int steps() const { return int(result_.trace.size()); }

  void stop(StopReason reason, const std::string& message) {
    result_.reason = reason;
    result_.message = message;
  }
  void stop_converged(const Step& step) {
    if (problem_->is_flat() && cost() > 0.0) {
      return stop(StopReason::kSingular,
                  "No residual changes with any variable here: robust losses give every factor the "
                  "weight 0, or the residuals are flat. Start nearer to the answer.");
    }
    char text[96];
    std::snprintf(text, sizeof text, "Converged: the last step was %.1e standard deviations.",
                  step.sigma / sigma_unit());
    stop(StopReason::kConverged, text + faded_variables());
  }
  void stop_no_decrease() {
    const std::string faded = faded_variables();
    stop(StopReason::kNoDecrease,
         faded.empty()
             ? "No step reduces the cost: the residuals are rough, or a Jacobian is wrong."
             : "No step reduces the cost." + faded);
  }
  // Names the first factor that is at fault.
  void stop_not_finite(const std::string& sentence) {
    const std::optional<NotFinite> found = find_not_finite(graph_, problem_->values());
    stop(StopReason::kNotFinite, sentence + (found ? ": " + found->what : "") + ".");
  }
  void stop_singular() {
    std::string message = "The data leave a combination of variables undetermined";
    const Values at = problem_->values();
    LinearSystem system(graph_, at);
    system.linearize(at);
    const auto found =
        attempt([&] { return find_null_space(system, *make_linear_solver(options_.backend)); });
    if (!found) return stop_not_finite(kNotFiniteMessage);
    const std::vector<NullDirection>& null = *found;
    if (null.empty() && options_.form == EliminationForm::kInformation) {
      return stop(StopReason::kSingular,
                  "The data determine all variables, but some too weakly for the information form; "
                  "use the square-root form.");
    }
    if (!null.empty()) message += ": " + describe(null, at);
    stop(StopReason::kSingular, message + ". Add a factor on it: a measurement or a prior.");
  }

  Result finish() {
    result_.values = problem_->values();
    result_.cost_final = cost();
    result_.iterations = steps();
    result_.gradient_norm = std::isfinite(cost()) ? gradient_norm() : cost();
    result_.solver = problem_->solver();
    result_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    return std::move(result_);
  }

 private:
  double small_sigma() const {
    return std::max(options_.step_tolerance * sigma_unit(), variables_rounding_);
  }
  void find_rounding() { variables_rounding_ = kVariablePrecision * problem_->sizes_in_sigmas(); }

  // Variables without influence where they are now, though they had some on the way: a plateau.
  std::string faded_variables() const {
    const VectorXd &norms = problem_->norms(), &largest = problem_->largest_norms();
    const Values at = problem_->values();
    std::string names;
    for (const Values::Slot& s : at.slots()) {
      bool faded = false;
      for (int i = 0; i < s.type.tangent(); ++i) {
        const int c = s.tangent + i;
        const double x = s.type.kind == 'R' ? 1.0 : std::abs(at.data()[std::size_t(s.stored + i)]);
        faded |= norms[c] <= kNullTolerance * largest[c] && largest[c] > 0.0 &&
                 norms[c] * x <= kNullTolerance * sigma_unit();
      }
      if (faded) names += (names.empty() ? "" : ", ") + to_string(s.key);
    }
    if (names.empty()) return names;
    return " On the way there " + names +
           " lost all influence on the residuals: this may be a plateau; start elsewhere, or use "
           "damp_by_largest_norm and a larger initial_damping.";
  }

  const FactorGraph& graph_;
  OptimizerOptions options_;
  std::chrono::steady_clock::time_point start_;
  int columns_;
  std::unique_ptr<OptimizerProblem> problem_;
  double variables_rounding_ = 0.0;  // in standard deviations
  Values base_;
  Result result_;
};

}  // namespace

std::string to_string(StopReason reason) {
  switch (reason) {
    case StopReason::kConverged:
      return "converged";
    case StopReason::kMaxIterations:
      return "max_iterations";
    case StopReason::kNoDecrease:
      return "no_decrease";
    case StopReason::kSingular:
      return "singular";
    case StopReason::kNotFinite:
      return "not_finite";
    case StopReason::kDiverged:
      return "diverged";
  }
  return "?";
}

namespace {

// Goes on from where a step has led that rose. False, and all is as before, unless the cost comes
// to be lower than where that step began, by what makes a step worth taking.
bool comes_down(Run& run, const Step& rising, double damping, const OptimizerOptions& options) {
  const double begin = run.cost();
  run.set_out();
  const auto take = [&](const Step& step) {
    const double gradient_norm = run.gradient_norm(), before = run.cost();
    run.accept();
    run.record(step, (before - run.cost()) / step.predicted_decrease, true, gradient_norm);
  };
  take(rising);
  for (int i = 0; i < kStepsDown && run.steps() < options.max_iterations; ++i) {
    Step step;
    if (!run.solve(damping) || !(run.try_step(step, damping) < run.cost())) break;
    take(step);
    const double decrease = begin - run.cost();
    if (decrease > options.min_gain_ratio * rising.predicted_decrease) return true;
  }
  run.go_back(damping);
  return false;
}

}  // namespace

Result LevenbergMarquardt::optimize(const Values& initial) const {
  Run run(graph_, options_, initial);
  if (!run.start_is_finite()) return run.finish();
  double damping = options_.initial_damping, growth = 2.0;
  run.stop(StopReason::kMaxIterations,
           "The limit of " + std::to_string(options_.max_iterations) +
               " iterations was reached; the result is not the optimum.");
  bool tried = false;  // to come down from a step that rose, from here
  while (run.steps() < options_.max_iterations) {
    const double used = damping < options_.min_damping ? 0.0 : damping;
    const double gradient_norm = run.gradient_norm();
    Step step;
    bool accepted = false;
    double gain_ratio = 0.0, cost = run.cost();
    const bool solved = run.solve(used);
    if (solved) {
      cost = run.try_step(step, used);
      const double decrease = run.cost() - cost;
      const bool at_rounding = run.negligible(step.predicted_decrease) && run.negligible(decrease);
      gain_ratio = at_rounding ? 1.0 : decrease / step.predicted_decrease;
      accepted = std::isfinite(cost) && gain_ratio > options_.min_gain_ratio;
      if (accepted) run.accept();
      if (options_.may_rise && !accepted && !tried && std::isfinite(cost) &&
          step.damping <= kLightDamping && !run.small(step)) {
        tried = true;
        if (comes_down(run, step, used, options_)) {
          tried = false;
          continue;
        }
      }
    } else if (!run.linearization_is_finite()) {
      run.stop_not_finite(kNotFiniteMessage);
      break;
    }
    if (!solved) step.damping = used;
    run.record(step, gain_ratio, accepted, gradient_norm);
    // A heavily damped step is short for another reason than being at the optimum. A light one of
    // this length is at the optimum even if rejected: what it would gain is below rounding.
    if (solved && step.damping <= kLightDamping && run.small(step)) {
      run.stop_converged(step);
      break;
    }
    if (accepted) {
      tried = false;
      const double g = 2.0 * gain_ratio - 1.0;
      damping = std::max(options_.min_damping * 0.1,
                         damping * std::max(kFastestDecrease, 1.0 - g * g * g));
      growth = 2.0;
    } else {
      damping = std::max(damping, options_.min_damping) * growth;
      growth *= 2.0;
      if (damping > options_.max_damping) {
        run.stop_no_decrease();
        break;
      }
    }
  }
  return run.finish();
}

Result GaussNewton::optimize(const Values& initial) const {
  OptimizerOptions undamped = options_;
  undamped.initial_damping = 0.0;
  Run run(graph_, undamped, initial);
  if (!run.start_is_finite()) return run.finish();
  run.stop(StopReason::kMaxIterations,
           "The limit of " + std::to_string(options_.max_iterations) +
               " iterations was reached; the result is not the optimum.");
  int rises = 0;
  while (run.steps() < options_.max_iterations) {
    const double gradient_norm = run.gradient_norm();
    Step step;
    if (!run.solve(0.0)) {
      if (run.linearization_is_finite()) {
        run.stop_singular();
      } else {
        run.stop_not_finite(kNotFiniteMessage);
      }
      break;
    }
    const double before = run.cost();
    run.try_step(step, 0.0);
    run.accept();
    if (!std::isfinite(run.cost())) {
      run.stop_not_finite(
          "A full step led to residuals that are not finite numbers (Levenberg-Marquardt would "
          "have shortened it)");
      break;
    }
    run.record(step, (before - run.cost()) / step.predicted_decrease, true, gradient_norm);
    if (run.small(step)) {
      run.stop_converged(step);
      break;
    }
    rises = run.cost() > before ? rises + 1 : 0;
    if (rises >= kMaxRises) {
      run.stop(StopReason::kDiverged, "The cost rose over " + std::to_string(kMaxRises) +
                                          " full steps; use Levenberg-Marquardt or start nearer.");
      break;
    }
  }
  return run.finish();
}

}  // namespace magimu
