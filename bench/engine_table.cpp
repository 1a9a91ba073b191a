// SPDX-License-Identifier: BSD-3-Clause
// The tables of the comparison of speed: engine_table.h.
#include "bench/engine_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace magimu {
namespace {

constexpr double kSameCost = 2e-9;
constexpr const char* kHeader =
    "| solver | threads | iterations | ms an iteration | s in all | CPU s | cost over the least | "
    "MB | textbook / this, an iteration | Ceres / this, in all |\n"
    "|---|---|---|---|---|---|---|---|---|---|\n";

template <class Number>
double median(const std::vector<Measured>& runs, const Number& number) {
  std::vector<double> all;
  for (const Measured& m : runs) all.push_back(number(m));
  const auto middle = all.begin() + std::ptrdiff_t(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

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
  const EngineRow* best = nullptr;
  for (const EngineRow& row : rows) {
    if (row.solver.camp != Camp::kCeres || row.solver.threads != threads) continue;
    if (!row.failure().empty()) continue;
    if (best == nullptr || row.wall_s() < best->wall_s()) best = &row;
  }
  return best;
}

// How many times as long an iteration takes the textbook, and the whole solve Ceres.
std::string ratios(const EngineRow& row, const std::vector<EngineRow>& rows) {
  const int threads = row.solver.threads;
  const EngineRow* book = textbook(rows);
  const EngineRow* ceres = fastest_ceres(rows, threads);
  const bool library = row.solver.camp == Camp::kLibrary;
  std::string out;
  const double own = row.counted_s(threads);
  if (library && book != nullptr) {
    const double one = book->counted_s(threads) / book->iterations();
    out += fmt::format("{:.2f}", one * row.iterations() / own);
  }
  out += " | ";
  if (library && ceres != nullptr) out += fmt::format("{:.2f}", ceres->counted_s(threads) / own);
  return out;
}

std::string line(const EngineRow& row, const std::vector<EngineRow>& rows) {
  const std::string head = fmt::format("| {} | {} | ", row.solver.name, row.solver.threads);
  if (!row.failure().empty()) return head + row.failure() + " |\n";
  const Measured& last = row.runs.back();
  const double memory = median(row.runs, [](const Measured& m) { return m.memory_mb; });
  return head + fmt::format("{}{} | {:.2f} | {:.4g} | {:.4g} | {:.1e} | {:.0f} | {} |\n",
                            last.iterations, last.converged ? "" : " (not converged)",
                            1e3 * row.counted_s(row.solver.threads) / row.iterations(),
                            row.wall_s(), row.cpu_s(), last.cost / least_cost(rows) - 1.0, memory,
                            ratios(row, rows));
}

}  // namespace

std::string EngineRow::failure() const {
  for (const Measured& m : runs) {
    if (!m.failure.empty()) return m.failure;
  }
  return "";
}

double EngineRow::wall_s() const {
  return median(runs, [](const Measured& m) { return m.wall_s; });
}

double EngineRow::cpu_s() const {
  return median(runs, [](const Measured& m) { return m.cpu_s; });
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
