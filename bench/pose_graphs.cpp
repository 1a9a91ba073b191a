// SPDX-License-Identifier: BSD-3-Clause
// Rotation averaging over public 3D pose graphs (general graphs with loops) with every back end
// that can serve, from a spanning-tree start; prints a table. See bench/README.md.
//   bench_pose_graphs [FILE...]      default: every .g2o file in pose_graphs/ of the data folder
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "solvers/levenberg_marquardt.h"
#include "tests/solvers/rotation_averaging.h"

namespace magimu {
namespace {

std::vector<std::string> default_files() {
  std::vector<std::string> paths;
  const std::string folder = std::string(MAGIMU_DATA_DIR) + "/pose_graphs";
  if (!std::filesystem::is_directory(folder)) return paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".g2o") paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
    return std::filesystem::file_size(a) < std::filesystem::file_size(b);
  });
  return paths;
}

// False if it did not converge; a back end that cannot serve prints nothing and is no failure.
bool print_row(const std::string& name, const g2o::File& file, const g2o::RotationAveraging& p,
               Backend backend) {
  OptimizerOptions options;
  options.backend = backend;
  try {
    const Result r = LevenbergMarquardt(p.graph, options).optimize(p.start);
    fmt::print("| {} | {} | {} | {:.4f} | {:.8f} | {:.1e} | {} | {:.3f} | {} |{}\n", name,
               file.rotations.size(), file.edges.size(), r.cost_initial, r.cost_final,
               r.gradient_norm, r.iterations, r.seconds, to_string(backend),
               r.converged() ? "" : " " + r.message);
    return r.converged();
  } catch (const std::invalid_argument&) {
    return true;  // not built in, or the graph has not the form
  }
}

}  // namespace
}  // namespace magimu

int main(int argc, char** argv) {
  using namespace magimu;
  std::vector<std::string> paths(argv + 1, argv + argc);
  if (paths.empty()) paths = default_files();
  if (paths.empty()) {
    fmt::print("No pose graphs: name some, or see bench/README.md for where to get them.\n");
    return 0;
  }
  fmt::print(
      "| graph | nodes | edges | initial cost | final cost | gradient | steps | s | back end |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  bool all = true;
  for (const std::string& path : paths) {
    const g2o::File file = g2o::read_file(path);
    const g2o::RotationAveraging problem = g2o::rotation_averaging(file);
    const std::string name = std::filesystem::path(path).stem().string();
    for (const Backend backend :
         {Backend::kChain, Backend::kCholmod, Backend::kSpqr, Backend::kEigen}) {
      all = print_row(name, file, problem, backend) && all;
    }
  }
  return all ? 0 : 1;
}
