// SPDX-License-Identifier: BSD-3-Clause
// Who takes part in the comparison of speed: the textbook's Gauss-Newton, Ceres where it is
// installed, and the library's back ends.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/engine/engine_problem.h"
#include "bench/engine/forked.h"

namespace magimu {

enum class Camp { kTextbook, kCeres, kLibrary };

struct EngineSolver {
  Camp camp = Camp::kLibrary;
  std::string name;
  int threads = 1;
  std::function<bool(const EngineProblem&)> fits;
  std::function<Solved(const EngineProblem&)> solve;
  // Where its iterations can be had one by one: after this has set up, each call of what it returns
  // is one.
  std::function<std::function<void()>(const EngineProblem&)> iterations;
};

// every_setting: all settings of Ceres that are worth a try, not only the best.
std::vector<EngineSolver> engine_solvers(const std::vector<int>& threads, bool every_setting);

}  // namespace magimu
