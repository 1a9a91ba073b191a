// SPDX-License-Identifier: BSD-3-Clause
// Magnetic-field-aided inertial navigation on given recordings of an array (bench/README.md): the
// published filters, what their steps' readings cost, and the filter for a coloured truncation.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <numbers>

#include "navigation/navigation_study.h"

namespace {

using namespace magimu;

constexpr double kDegrees = 180.0 / std::numbers::pi;

void print_row(const NavigationVariant& variant, const NavigationStudyRow& row) {
  const NavigationSummary& s = row.summary;
  fmt::print(
      "{:<50} {:8.4f} {:8.4f} {:6.2f} {:6.2f} {:7.2f} {:7.2f} {:7.3f} {:7.3f} {:7.3f} {:6.2f} "
      "{:6.0f}\n",
      variant.name, s.position_rmse, s.position_sigma, s.yaw_rmse * kDegrees,
      s.yaw_sigma * kDegrees, s.position_nees, s.position_nees_throughout, s.field_nis, s.all_nis,
      s.residual_nis, 100.0 * s.median_final_over_distance, row.times_real_time);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Navigation with an array of magnetometers, on recordings with their truth"};
  std::string folder = MAGIMU_DATA_DIR "/array_navigation";
  bool simulated = false;
  int runs = 10;
  double moment = ArrayRoomOptions().moment;
  app.add_option("folder", folder, "of MATLAB files of the OC-MAINS set");
  app.add_flag("--simulated", simulated, "our own room of dipoles instead");
  app.add_option("--runs", runs, "of the simulation");
  app.add_option("--moment", moment, "of the simulated room's dipoles, A m^2");
  CLI11_PARSE(app, argc, argv);

  std::vector<NavigationCase> cases;
  if (simulated) {
    for (int i = 1; i <= runs; ++i)
      cases.push_back(simulated_case(static_cast<unsigned>(i), moment));
  } else {
    if (!std::filesystem::is_directory(folder)) {
      fmt::print("There is no folder {}: nothing was measured.\n", folder);
      return 1;
    }
    cases = navigation_cases(folder);
  }
  fmt::print(
      "{} recordings\n\n{:<50} {:>8} {:>8} {:>6} {:>6} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6} "
      "{:>6}\n",
      cases.size(), "", "p m", "claimed", "yaw", "claim", "NEES/3", "always", "NIS", "NIS all",
      "resid", "end %", "x real");
  for (const NavigationVariant& variant : navigation_variants()) {
    print_row(variant, run_variant(variant, cases));
  }
  if (simulated) {
    const NavigationVariant variant = at_true_field_variant();
    print_row(variant, run_variant(variant, cases));
  }
}
