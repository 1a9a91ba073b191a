// SPDX-License-Identifier: BSD-3-Clause
// The library's graphs solved by Ceres, to compare: the same residuals, the same analytic
// Jacobians, the same increments of rotations. Built only where Ceres is found; nothing else
// depends on it.
#pragma once

#include <string>
#include <vector>

#include "bench/engine/forked.h"
#include "graph/factor_graph.h"

namespace magimu {

struct CeresSetting {
  enum class Library { kSuiteSparse, kCxSparse, kEigen };

  std::string name;
  Library library = Library::kSuiteSparse;
  bool schur = false;         // of half the nodes first; the normal equations as they are otherwise
  bool globals_last = false;  // what all nodes share is eliminated last; left to Ceres otherwise
  bool scaling = true;        // columns scaled to unit norm
};

std::string ceres_version();

// The best, found by trying: one for few parameters, one for many. Or all that were tried.
std::vector<CeresSetting> ceres_settings(bool all);

// Times are Ceres's solve alone, without the building of its problem. Throws std::invalid_argument
// for a graph with factors of a type that peer_ceres.cpp does not know.
Solved solve_with_ceres(const FactorGraph& graph, const Values& start, const CeresSetting& setting,
                        int threads);

}  // namespace magimu
