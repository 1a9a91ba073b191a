// SPDX-License-Identifier: BSD-3-Clause
// The tables of the comparison of speed: engine_table.h.
#include "bench/engine/engine_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kSameCost = 2e-9;
constexpr const char* kHeader =
    "| solver | threads | iterations | ms an iteration | the same without set-up | s in all | CPU "
    "s "
    "| cost over the least | MB | textbook / this, an iteration | without set-up | Ceres / this, "
    "in "
    "all |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";

template <class Number>
double median(const std::vector<Measured>& runs, const Number& number) {
  std::vector<double> all;
  for (const Measured& m : runs) all.push_back(number(m));
  return magimu::median(std::move(all));
}

double wall_s(const Measured& m) { return m.wall_s; }
double cpu_s(const Measured& m) { return m.cpu_s; }

// The time that iterations and ratios are given in. With one thread: processor time, since other
// work of the machine would count in wall time. With several threads: wall time.
auto counted(int threads) { return threads == 1 ? cpu_s : wall_s; }

double least_cost(const std::vector<EngineRow>& rows) {
  double least = std::numeric_limits<double>::infinity();
  for (const EngineRow& row : rows) {
    if (row.failure().empty() && row.runs.back().converged) {
      least = std::min(least, row.runs.back().cost);
    }
  }
  return least;
}

const EngineRow* textbook(const std::vector<EngineRow>& rows) {
  for (const EngineRow& row : rows) {
    if (row.solver.camp == Camp::kTextbook && row.failure().empty()) return &row;
  }
  return nullptr;
}

// The fastest of Ceres's settings with so many threads.
const EngineRow* fastest_ceres(const std::vector<EngineRow>& rows, int threads) {
  const auto seconds = counted(threads);
  const EngineRow* best = nullptr;
  for (const EngineRow& row : rows) {
    if (row.solver.camp != Camp::kCeres || row.solver.threads != threads) continue;
    if (!row.failure().empty()) continue;
    if (best == nullptr || median(row.runs, seconds) < median(best->runs, seconds)) best = &row;
  }
  return best;
}

// The other solver's time over our own, median over the turns. The two of a turn run one after the
// other, so that whatever slows the machine slows both.
double ratio(const std::vector<Measured>& other, const std::vector<Measured>& own, int threads) {
  const auto seconds = counted(threads);
  std::vector<double> all;
  for (std::size_t i = 0; i < own.size(); ++i) all.push_back(seconds(other[i]) / seconds(own[i]));
  return magimu::median(std::move(all));
}

// The textbook's iteration over this one's, with and without set-up; Ceres's whole solve over this
// one's.
std::string ratios(const EngineRow& row, const std::vector<EngineRow>& rows) {
  if (row.solver.camp != Camp::kLibrary) return "| | ";
  const int threads = row.solver.threads;
  std::string out;
  const EngineRow* book = textbook(rows);
  if (book != nullptr) {
    out = fmt::format("{:.2f} ",
                      ratio(book->runs, row.runs, threads) * row.iterations() / book->iterations());
  }
  out += "| ";
  if (book != nullptr && !row.iterations_alone.empty()) {
    out += fmt::format("{:.2f} ", ratio(book->iterations_alone, row.iterations_alone, threads));
  }
  out += "| ";
  if (const EngineRow* ceres = fastest_ceres(rows, threads)) {
    out += fmt::format("{:.2f} ", ratio(ceres->runs, row.runs, threads));
  }
  return out;
}

// Three digits, without exponents.
std::string digits(double x) {
  return x < 100.0 ? fmt::format("{:.3g}", x) : fmt::format("{:.0f}", x);
}

std::string line(const EngineRow& row, const std::vector<EngineRow>& rows) {
  const std::string head = fmt::format("| {} | {} | ", row.solver.name, row.solver.threads);
  if (!row.failure().empty()) return head + row.failure() + " |\n";
  const Measured& last = row.runs.back();
  const double ms = 1e3 * median(row.runs, counted(row.solver.threads)) / row.iterations();
  std::string alone;
  if (!row.iterations_alone.empty()) {
    alone = digits(1e3 * median(row.iterations_alone, counted(row.solver.threads))) + " ";
  }
  const double memory = median(row.runs, [](const Measured& m) { return m.memory_mb; });
  return head + fmt::format("{}{} | {} | {}| {} | {} | {:.0e} | {:.0f} | {}|\n", last.iterations,
                            last.converged ? "" : " (not converged)", digits(ms), alone,
                            digits(median(row.runs, wall_s)), digits(median(row.runs, cpu_s)),
                            last.cost / least_cost(rows) - 1.0, memory, ratios(row, rows));
}

}  // namespace

std::string EngineRow::failure() const {
  for (const Measured& m : runs) {
    if (!m.failure.empty()) return m.failure;
  }
  return "";
}

int EngineRow::iterations() const { return std::max(1, runs.back().iterations); }

std::string engine_table(const EngineProblem& problem, const std::vector<EngineRow>& rows) {
  std::string out =
      fmt::format("**{}**: {} nodes, {} unknowns, {} factors, least cost {:.9g}\n\n", problem.name,
                  problem.nodes, problem.start.dim(), problem.graph.size(), least_cost(rows));
  out += kHeader;
  for (const EngineRow& row : rows) out += line(row, rows);
  return out + "\n";
}

bool same_optimum(const std::vector<EngineRow>& rows) {
  const double least = least_cost(rows);
  return std::all_of(rows.begin(), rows.end(), [&](const EngineRow& row) {
    if (!row.failure().empty() || !row.runs.back().converged) return true;
    return row.runs.back().cost <= least * (1.0 + kSameCost);
  });
}

}  // namespace magimu
