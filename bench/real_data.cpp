// SPDX-License-Identifier: BSD-3-Clause
// Calibrates real recordings that carry an optical truth (BROAD), and prints a line for each:
// orientation error against the cameras, plausibility of the parameters, verdict.
//   bench_real_data [FILE...]      default: every recording in the data folder
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "calibration/calibrate.h"
#include "calibration/orientation_error.h"
#include "recording/read.h"

int main(int argc, char** argv) {
  using namespace magimu;
  std::vector<std::string> paths(argv + 1, argv + argc);
  if (paths.empty()) {
    const std::string folder = std::string(MAGIMU_DATA_DIR) + "/broad";
    if (!std::filesystem::is_directory(folder)) {
      fmt::print("No recordings: name some, or see README.md for where to get them.\n");
      return 0;
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      paths.push_back(entry.path().string());
    }
    std::sort(paths.begin(), paths.end());
  }
  fmt::print("{:<44} {:>6} {:>6} {:>6} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6}  {}\n", "recording",
             "total", "head.", "incl.", "|o_a|", "acc res", "mag res", "dip", "uT", "s", "trust");
  for (const std::string& path : paths) {
    const Recording recording = read_recording(path);
    CalibrationOptions options;
    if (getenv("MOTION")) options.motion = getenv("MOTION")[0]=='r' ? MotionModel::kRotation : MotionModel::kHandHeld;
    if (getenv("OFFSET")) options.mag_time_offset = getenv("OFFSET")[0]=='1';
    if (getenv("MAGN")) options.noise = NoiseDensities{0.0035, atof(getenv("GYRN")), atof(getenv("MAGN"))};
    const Calibration c = calibrate(recording, options);
    OrientationError e;
    if (recording.truth) e = orientation_error(c.trajectories.front(), *recording.truth);
    fmt::print(
        "{:<44} {:6.2f} {:6.2f} {:6.2f} {:7.3f} {:7.3f} {:7.3f} {:7.2f} {:6.2f} {:6.2f}  {} ({})\n",
        recording.name, e.total_deg, e.heading_deg, e.inclination_deg,
        c.parameters.acc_bias.norm(), c.residuals[0].rms_unit, c.residuals[2].rms_unit,
        c.parameters.dip_rad / kDegree, c.strength_uT, c.seconds, to_string(c.trust.verdict),
        to_string(c.fit.reason));
    fmt::print("    {} reach {:.2f} lag {:.2f} ms;noise acc {:.4f} gyr {:.5f} mag {:.4f}; gyr bias {:.5f} {:.5f} {:.5f}; mag bias {:.2f} {:.2f} {:.2f}\n", to_string(c.motion), c.reach_m, c.effects.empty()?0.0:1e3*c.effects[0].parameters[0].value, c.noise.acc, c.noise.gyr,
               c.noise.mag, c.parameters.gyr_bias[0],c.parameters.gyr_bias[1],c.parameters.gyr_bias[2], c.parameters.mag[0].bias[0],c.parameters.mag[0].bias[1],c.parameters.mag[0].bias[2]);
  }
  return 0;
}
