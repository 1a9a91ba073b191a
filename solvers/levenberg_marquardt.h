// SPDX-License-Identifier: BSD-3-Clause
// Nonlinear least squares on manifolds: Levenberg-Marquardt and Gauss-Newton. Each step minimizes
// the linearized cost |r + J delta|^2 / 2 + lambda |delta / S|^2 / 2, S the inverse column norms of
// J, and is taken if the cost really falls (gain ratio: actual over predicted decrease). A change
// of the cost that rounding explains is no rise: near the optimum the model is believed.
//
// Where a narrow valley bends, only very short steps go downhill. With OptimizerOptions::may_rise a
// full step that leaves the valley's floor is followed by others from there, and is taken with them
// if they end lower than it began; else it is taken back (the watchdog technique of Chamberlain,
// Powell, Lemarechal and Pedersen 1982).
//
//   FactorGraph graph;  Values values;   // ...
//   const Result result = LevenbergMarquardt(graph).optimize(values);
//   if (!result.converged()) std::cerr << result.message << "\n";
//
// Not thread safe: one optimizer a thread. The result does not depend on the number of threads.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "graph/factor_graph.h"
#include "solvers/linear/optimizer_options.h"

namespace magimu {

enum class StopReason {
  kConverged,      // the last step was below step_tolerance
  kMaxIterations,  // max_iterations steps were not enough
  kNoDecrease,     // no step reduces the cost, though the model promises a decrease
  kSingular,       // the data leave some combination of variables free
  kNotFinite,      // a residual or Jacobian is not a finite number
  kDiverged,       // Gauss-Newton: the cost rose over several steps
};

std::string to_string(StopReason reason);

// One tried step.
struct IterationRecord {
  int iteration = 0;
  double cost = 0.0;           // after the step, if it was accepted; before it otherwise
  double gradient_norm = 0.0;  // of the cost, in columns of unit norm, before the step
  double step_norm = 0.0;      // |delta|, mixed units
  double step_sigma = 0.0;     // the step's length in standard deviations
  double damping = 0.0;
  double gain_ratio = 0.0;
  bool accepted = false;
};

struct Result {
  Values values;
  StopReason reason = StopReason::kMaxIterations;
  std::string message;  // the reason in a sentence
  int iterations = 0;   // linearizations
  double cost_initial = 0.0, cost_final = 0.0;
  double gradient_norm = 0.0, step_norm = 0.0;
  double seconds = 0.0;
  std::string solver;  // by what the steps were solved for: "windows, AVX2, square root"
  std::vector<IterationRecord> trace;

  bool converged() const { return reason == StopReason::kConverged; }
};

class LevenbergMarquardt {
 public:
  // The graph must outlive the optimizer: a temporary one is refused.
  explicit LevenbergMarquardt(const FactorGraph& graph, const OptimizerOptions& options = {})
      : graph_(graph), options_(options) {}
  explicit LevenbergMarquardt(const FactorGraph&& temporary,
                              const OptimizerOptions& options = {}) = delete;
  Result optimize(const Values& initial) const;

 private:
  const FactorGraph& graph_;
  OptimizerOptions options_;
};

// Full steps without damping: for problems well posed and well started.
class GaussNewton {
 public:
  // As for LevenbergMarquardt.
  explicit GaussNewton(const FactorGraph& graph, const OptimizerOptions& options = {})
      : graph_(graph), options_(options) {}
  explicit GaussNewton(const FactorGraph&& temporary,
                       const OptimizerOptions& options = {}) = delete;
  Result optimize(const Values& initial) const;

 private:
  const FactorGraph& graph_;
  OptimizerOptions options_;
};

}  // namespace magimu
