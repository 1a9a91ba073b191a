// SPDX-License-Identifier: BSD-3-Clause
// The solvers that are compared: engine_solvers.h.
#include "bench/engine/engine_solvers.h"

#include <tbb/global_control.h>

#include <cmath>
#include <memory>
#include <optional>

#include "solvers/lanes/window_engine.h"
#include "solvers/levenberg_marquardt.h"
#ifdef MAGIMU_WITH_CERES
#include "bench/engine/peer_ceres.h"
#endif

namespace magimu {
namespace {

// The library's own: one more back end is one more line.
struct LibrarySetting {
  Backend backend;
  bool gauss_newton = false;  // full steps; Levenberg-Marquardt otherwise
  std::optional<EliminationForm> form = std::nullopt;
};
constexpr LibrarySetting kLibrary[] = {
    {Backend::kWindows, true},
    {Backend::kWindows},
    {Backend::kWindows, true, EliminationForm::kSquareRoot},
    {Backend::kWindows, false, EliminationForm::kSquareRoot},
    {Backend::kChain, true},
    {Backend::kChain},
    {Backend::kCholmod},
    {Backend::kSpqr},
};

constexpr double kStep = 1e-6;      // |dx| at which the textbook stops
constexpr int kMaxIterations = 30;  // of the textbook

// Where a step gains less than kSmallGain of the cost, about half of the number of rows.
double step_tolerance(const FactorGraph& graph) {
  double rows = 0.0;
  for (const auto& batch : graph.batches()) rows += double(batch->rows()) * batch->size();
  return std::sqrt(kSmallGain * rows);
}

Solved solve_textbook(const EngineProblem& problem) {
  const Stopwatch watch;
  Textbook textbook(*problem.textbook_data, problem.textbook_start);
  Solved out;
  while (!out.converged && out.iterations < kMaxIterations) {
    const double step = textbook.iterate();
    ++out.iterations;
    if (!std::isfinite(step)) break;
    out.converged = step < kStep;
  }
  out.wall_s = watch.wall_s();
  out.cpu_s = watch.cpu_s();
  out.values = to_values(problem.start, textbook.unknowns());
  return out;
}

EngineSolver textbook() {
  EngineSolver out;
  out.iterations = [](const EngineProblem& problem) {
    auto book = std::make_shared<Textbook>(*problem.textbook_data, problem.textbook_start);
    return [book] { book->iterate(); };
  };
  out.camp = Camp::kTextbook;
  out.name = "textbook";
  out.fits = [](const EngineProblem& problem) { return problem.textbook_data.has_value(); };
  out.solve = solve_textbook;
  return out;
}

// Full steps from here on: solved for, taken, linearized and condensed where they lead.
std::function<void()> window_iterations(const EngineProblem& problem, EliminationForm form,
                                        int threads) {
  std::shared_ptr<WindowEngine> engine =
      WindowEngine::make(problem.graph, problem.start, std::nullopt, form);
  engine->load(problem.start);
  engine->condense(0.0);
  return [engine, threads] {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(threads));
    engine->solve();
    engine->advance(0.0);
    engine->keep_candidate();
  };
}

EngineSolver library(const LibrarySetting& setting, int threads) {
  EngineSolver out;
  if (setting.backend == Backend::kWindows && setting.gauss_newton) {
    out.iterations = [setting, threads](const EngineProblem& problem) {
      return window_iterations(problem, setting.form.value_or(EliminationForm::kInformation),
                               threads);
    };
  }
  out.name = "magimu, " + to_string(setting.backend);
  if (setting.form) out.name += std::string(", ") + to_string(*setting.form);
  if (setting.gauss_newton) out.name += ", Gauss-Newton";
  out.threads = threads;
  out.fits = [](const EngineProblem&) { return true; };
  out.solve = [setting, threads](const EngineProblem& problem) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(threads));
    OptimizerOptions options;
    options.backend = setting.backend;
    options.form = setting.form;
    options.step_tolerance = step_tolerance(problem.graph);
    const Stopwatch watch;
    Result result = setting.gauss_newton
                        ? GaussNewton(problem.graph, options).optimize(problem.start)
                        : LevenbergMarquardt(problem.graph, options).optimize(problem.start);
    return Solved{std::move(result.values), result.iterations, result.converged(), watch.wall_s(),
                  watch.cpu_s()};
  };
  return out;
}

#ifdef MAGIMU_WITH_CERES
EngineSolver ceres_peer(const CeresSetting& setting, int threads) {
  EngineSolver out;
  out.camp = Camp::kCeres;
  out.name = "Ceres " + ceres_version() + ", " + setting.name;
  out.threads = threads;
  out.fits = [](const EngineProblem&) { return true; };
  out.solve = [setting, threads](const EngineProblem& problem) {
    return solve_with_ceres(problem.graph, problem.start, setting, threads);
  };
  return out;
}
#endif

}  // namespace

std::vector<EngineSolver> engine_solvers(const std::vector<int>& threads,
                                         [[maybe_unused]] bool every_setting) {
  std::vector<EngineSolver> all = {textbook()};
#ifdef MAGIMU_WITH_CERES
  for (const CeresSetting& setting : ceres_settings(every_setting)) {
    for (const int n : threads) all.push_back(ceres_peer(setting, n));
  }
#endif
  for (const LibrarySetting& setting : kLibrary) {
    for (const int n : threads) all.push_back(library(setting, n));
  }
  return all;
}

}  // namespace magimu
