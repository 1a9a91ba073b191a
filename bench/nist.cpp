// SPDX-License-Identifier: BSD-3-Clause
// Fits the 27 nonlinear regressions of the NIST Statistical Reference Datasets from both of their
// starting points and prints, for the worst parameter of each, how many digits of the certified
// value are right, and how many of its certified standard deviation: by the normal equations and by
// orthogonal factorization. See bench/README.md.
//   bench_nist [FOLDER]      default: nist/ in the data folder
#include <fmt/format.h>

#include <filesystem>

#include "solvers/back_ends.h"
#include "tests/solvers/nist_problems.h"

namespace magimu {
namespace {

constexpr double kEnough = 6.0;  // digits

bool is_built_in(Backend backend) {
  try {
    make_linear_solver(backend);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

// Steps, digits, digits of the deviations with each back end; true if there are enough of them.
bool print_fit(const nist::Problem& problem, int start, std::string& note) {
  const nist::Fit f = nist::fit(problem, start, nist::options());
  fmt::print(" {:5} | {:4.1f} | {:4.1f} |", f.result.iterations, f.digits, f.deviation_digits);
  if (is_built_in(Backend::kSpqr)) {
    fmt::print(" {:4.1f} |",
               nist::fit(problem, start, nist::options(Backend::kSpqr)).deviation_digits);
  } else {
    fmt::print("    - |");
  }
  if (f.digits >= kEnough) return true;
  note += fmt::format("{}, start {}: {}\n", problem.file.name, start + 1, f.result.message);
  return false;
}

}  // namespace
}  // namespace magimu

int main(int argc, char** argv) {
  using namespace magimu;
  const std::string folder = argc > 1 ? argv[1] : std::string(MAGIMU_DATA_DIR) + "/nist";
  if (!std::filesystem::is_directory(folder)) {
    fmt::print("The NIST problems are not in {}; bench/README.md says where to get them.\n",
               folder);
    return 0;
  }
  fmt::print("| problem | level | b | data | steps | b | sd | sd QR | steps | b | sd | sd QR |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  int solved[2] = {0, 0};
  std::string notes;
  for (const std::string& name : nist::names()) {
    const nist::Problem p = nist::read_problem(folder, name);
    fmt::print("| {:8} | {:7} | {} | {:3} |", name, nist::level(name), p.file.parameters.size(),
               p.file.data.size());
    for (int start = 0; start < 2; ++start) solved[start] += print_fit(p, start, notes) ? 1 : 0;
    fmt::print("\n");
    if (!p.erratum.empty()) notes += name + ": " + p.erratum + "\n";
  }
  fmt::print("\n{} or more digits in every parameter: {} of {} from start 1, {} from start 2\n{}",
             kEnough, solved[0], nist::names().size(), solved[1], notes);
  return solved[0] >= 25 && solved[1] == int(nist::names().size()) ? 0 : 1;
}
