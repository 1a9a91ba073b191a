// SPDX-License-Identifier: BSD-3-Clause
// The 27 nonlinear regressions of the NIST Statistical Reference Datasets as graphs: one factor an
// observation, y - f(x; b), one vector b of parameters, Jacobians from automatic differentiation.
//   https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml
// The test and the program in bench/ share this.
#pragma once

#include <span>

#include "solvers/levenberg_marquardt.h"
#include "tests/solvers/nist_file.h"

namespace magimu::nist {

inline constexpr Key kParameters{'b', 0};
inline constexpr double kAllDigits = 11.0;  // as many as are certified

struct Problem {
  File file;
  FactorGraph graph;
  std::array<Values, 2> start;
  Values certified;
  // Empty, or which number of the file was replaced by what NIST publishes, and why.
  std::string erratum;
};

// The names as NIST spells them, from the lower level of difficulty to the higher.
std::span<const std::string> names();

// The level of difficulty, as NIST judges: lower, average, higher.
std::string level(const std::string& name);

// The problem of this name from folder/name.dat. Throws std::runtime_error where there is none.
Problem read_problem(const std::string& folder, const std::string& name);

// What a user sets who starts far away, knows nothing of the noise and wants all the digits.
OptimizerOptions options(Backend backend = Backend::kAuto);

struct Fit {
  Result result;
  // Correct digits, the worst parameter's: minus the decimal logarithm of the relative error.
  double digits = 0.0;
  // Of the standard deviations, from Marginals times the residuals' variance; 0 where Marginals
  // call the parameters undetermined.
  double deviation_digits = 0.0;
};
Fit fit(const Problem& problem, int start, const OptimizerOptions& options);

}  // namespace magimu::nist
