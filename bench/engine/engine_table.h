// SPDX-License-Identifier: BSD-3-Clause
// The comparison of speed as Markdown: a table a problem, all of it measured in one run.
#pragma once

#include <string>
#include <vector>

#include "bench/engine/engine_solvers.h"

namespace magimu {

// A solver's measurements of one problem.
struct EngineRow {
  EngineSolver solver;
  std::vector<Measured> runs;
  std::vector<Measured> iterations_alone;  // without set-up; where they can be had

  // Of the first run that failed; empty: none did.
  std::string failure() const;
  int iterations() const;
};

std::string engine_table(const EngineProblem& problem, const std::vector<EngineRow>& rows);

// Do all that converged end at the same cost, to 2e-9 of it?
bool same_optimum(const std::vector<EngineRow>& rows);

}  // namespace magimu
