// SPDX-License-Identifier: BSD-3-Clause
// How fast is a solve, and how fast could it be? The same graphs from the same start, solved by
// each of the library's back ends, by a textbook's Gauss-Newton written for this problem alone, and
// by Ceres where it was found: time, memory and final cost, as Markdown tables (bench/README.md).
// Each measurement is in a process of its own; the solvers take turns, so that what else the
// machine does meets all of them. Exit code 1 if two that converged end at different costs.
//   bench_engine [--case rotation|long|array|hand_held|all] [--repeat N] [--threads 1,2]
//                [--problem TEXT] [--only TEXT] [--limit SECONDS] [--every-setting]
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/engine/engine_table.h"

namespace magimu {
namespace {

struct Options {
  std::string family = "rotation", problem, only;
  int repeat = 5, limit_s = 120;
  std::vector<int> threads = {1, 2};
  bool every_setting = false;
};

// The time of one iteration, set-up not counted.
Solved iterations_alone(const EngineProblem& problem, const EngineSolver& solver) {
  constexpr int kFirst = 2, kCounted = 10;
  const std::function<void()> iterate = solver.iterations(problem);
  for (int i = 0; i < kFirst; ++i) iterate();
  const Stopwatch watch;
  for (int i = 0; i < kCounted; ++i) iterate();
  Solved out;
  out.iterations = kCounted;
  out.wall_s = watch.wall_s() / kCounted;
  out.cpu_s = watch.cpu_s() / kCounted;
  return out;
}

std::vector<EngineRow> measure(const EngineProblem& problem, const Options& o) {
  std::vector<EngineRow> rows;
  for (const EngineSolver& solver : engine_solvers(o.threads, o.every_setting)) {
    if (!solver.fits(problem) || solver.name.find(o.only) == std::string::npos) continue;
    rows.push_back({solver, {}, {}});
  }
  const auto cost = [&](const Values& values) { return problem.graph.cost(values); };
  for (int i = 0; i < o.repeat; ++i) {
    for (EngineRow& row : rows) {
      if (!row.failure().empty()) continue;  // it would fail again
      const auto solve = [&] { return row.solver.solve(problem); };
      row.runs.push_back(measure_in_child(solve, cost, o.limit_s));
      if (!row.solver.iterations) continue;
      const auto iterate = [&] { return iterations_alone(problem, row.solver); };
      const auto no_cost = [](const Values&) { return 0.0; };
      row.iterations_alone.push_back(measure_in_child(iterate, no_cost, o.limit_s));
    }
  }
  return rows;
}

// False if the solvers disagree.
bool run(const Options& o) {
  bool agree = true;
  for (const EngineCase& c : engine_cases(o.family)) {
    if (c.name.find(o.problem) == std::string::npos) continue;
    const EngineProblem problem = make_problem(c);
    // What is forked from here starts threads of its own: none of this process's are left.
    tbb::task_scheduler_handle scheduler{tbb::attach{}};
    tbb::finalize(scheduler, std::nothrow);
    const std::vector<EngineRow> rows = measure(problem, o);
    fmt::print("{}", engine_table(problem, rows));
    std::fflush(stdout);
    if (same_optimum(rows)) continue;
    agree = false;
    fmt::print("The costs differ by more than rounding explains.\n\n");
  }
  return agree;
}

int bench_engine(int argc, char** argv) {
  Options o;
  CLI::App app("How fast is a solve, and how fast could it be?");
  app.add_option("--case", o.family, "rotation, long, array, hand_held or all");
  app.add_option("--repeat", o.repeat, "measurements, of which the median is told")
      ->check(CLI::PositiveNumber);
  app.add_option("--threads", o.threads, "numbers of threads, such as 1,2")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  app.add_option("--problem", o.problem, "only problems whose name has this in it");
  app.add_option("--only", o.only, "only solvers whose name has this in it");
  app.add_option("--limit", o.limit_s, "seconds after which a measurement is given up")
      ->check(CLI::PositiveNumber);
  app.add_flag("--every-setting", o.every_setting,
               "all settings of Ceres that were tried, not only the best");
  try {
    app.parse(argc, argv);
    return run(o) ? 0 : 1;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_engine: {}\n", error.what());
    return 2;
  }
}

}  // namespace
}  // namespace magimu

int main(int argc, char** argv) { return magimu::bench_engine(argc, argv); }
