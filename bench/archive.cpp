// SPDX-License-Identifier: BSD-3-Clause
// What an archive of recordings gives: devices against their truth, and changes found, dated and
// invented. bench/archive.sh runs the program on a simulated fleet with kills, a full disk and
// broken files.
//
//   build/bench_archive nees --devices 40 --recordings 25
//   build/bench_archive together --devices 10 --recordings 4 [--given-noise] [--seconds 6]
//   build/bench_archive changes --devices 200 --recordings 25
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "bench/archive_devices.h"

int main(int argc, char** argv) {
  CLI::App app{"Archives: devices and their changes"};
  app.require_subcommand(1);
  magimu::ArchiveMade archive;
  std::vector<double> sizes{2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0};
  CLI::App* nees = app.add_subcommand("nees", "consistency of the devices' estimates");
  CLI::App* together =
      app.add_subcommand("together", "devices against all their samples calibrated together");
  CLI::App* changes = app.add_subcommand("changes", "steps of the hard iron, drifts of the scale");
  for (CLI::App* cmd : {nees, together, changes}) {
    cmd->add_option("--devices", archive.devices)->capture_default_str();
    cmd->add_option("--recordings", archive.recordings)->capture_default_str();
  }
  for (CLI::App* cmd : {nees, together}) {
    cmd->add_option("--seconds", archive.seconds, "of a recording")->capture_default_str();
    cmd->add_flag("--given-noise", archive.given_noise, "the densities are not estimated");
  }
  changes->add_option("--sizes", sizes, "sigmas of one recording");
  CLI11_PARSE(app, argc, argv);
  if (nees->parsed()) fmt::print("{}", magimu::device_nees(archive).text());
  if (together->parsed()) {
    std::vector<double> distances = magimu::distances_from_together(archive);
    std::ranges::sort(distances);
    if (distances.empty()) return 1;  // no device has an estimate
    fmt::print(
        "a device's estimate from the calibration of {} recordings together, in sigmas of one "
        "parameter: at most {:.4f} in the median of {} devices, {:.4f} in the worst (0.01 is "
        "asked)\n",
        archive.recordings, distances[distances.size() / 2], distances.size(), distances.back());
  }
  if (changes->parsed()) {
    fmt::print(
        "| change | size, sigmas | named | dated | flagged without cause "
        "|\n|---|---|---|---|---|\n");
    for (const bool drift : {false, true}) {
      for (const double size : sizes) {
        const magimu::ChangesReport r =
            magimu::device_changes(archive.devices, archive.recordings, size, drift);
        fmt::print("| {} | {} | {} of {} | {} | {} of {} |\n",
                   drift ? "drift of the scale" : "step of the hard iron", size, r.named_step,
                   r.changed, drift ? "" : fmt::format("{}", r.dated), r.false_alarms,
                   r.devices - r.changed);
      }
    }
  }
  return 0;
}
