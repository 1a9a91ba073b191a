// SPDX-License-Identifier: BSD-3-Clause
// Calibrates real recordings that carry an optical truth (BROAD), under each model of the motion,
// and prints a table: orientation error against the cameras (total, as delivered), parameters that
// must be plausible, verdict. See bench/README.md.
//   bench_real_data [FILE...]      default: every recording in the data folder
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "calibration/calibrate.h"
#include "calibration/orientation_error.h"
#include "recording/read.h"

namespace magimu {
namespace {

std::vector<std::string> default_recordings() {
  std::vector<std::string> paths;
  const std::string folder = std::string(MAGIMU_DATA_DIR) + "/broad";
  if (!std::filesystem::is_directory(folder)) return paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

void print_row(const Recording& recording, MotionModel motion) {
  CalibrationOptions options;
  options.motion = motion;
  const Calibration c = calibrate(recording, options);
  OrientationError e;
  if (recording.truth) e = orientation_error(c.trajectories.front(), *recording.truth);
  double lag_ms = 0.0, scale = 0.0;  // of the gyroscope: largest entry of its matrix
  for (const ActiveEffect& effect : c.effects) {
    if (effect.name == "mag_time_offset") lag_ms = 1e3 * effect.parameters[0].value;
    if (effect.name != "gyro_scale_misalignment") continue;
    for (const auto& p : effect.parameters) scale = std::max(scale, std::abs(p.value));
  }
  fmt::print(
      "{:<40} {:<9} {:6.2f} {:6.2f} {:6.2f} {:7.3f} {:6.2f} {:7.2f} {:6.2f} {:6.1f} {:6.2f} "
      "{:5.1f}  "
      "{}{}\n",
      recording.name, to_string(c.motion), e.total_deg, e.heading_deg, e.inclination_deg,
      c.parameters.acc_bias.norm(), c.residuals[2].rms_unit, c.parameters.dip_rad / kDegree,
      c.strength_uT, lag_ms, 100.0 * scale, c.seconds, to_string(c.trust.verdict),
      c.fit.converged() ? "" : " (not converged)");
}

}  // namespace
}  // namespace magimu

int main(int argc, char** argv) {
  using namespace magimu;
  std::vector<std::string> paths(argv + 1, argv + argc);
  if (paths.empty()) paths = default_recordings();
  if (paths.empty()) {
    fmt::print("No recordings: name some, or see README.md for where to get them.\n");
    return 0;
  }
  fmt::print("{:<40} {:<9} {:>6} {:>6} {:>6} {:>7} {:>6} {:>7} {:>6} {:>6} {:>6} {:>5}  {}\n",
             "recording", "model", "total", "head.", "incl.", "|o_a|", "mag", "dip", "uT", "lag",
             "S", "time", "trust");
  fmt::print("{:<40} {:<9} {:>6} {:>6} {:>6} {:>7} {:>6} {:>7} {:>6} {:>6} {:>6} {:>5}\n", "", "",
             "deg", "deg", "deg", "m/s^2", "uT", "deg", "", "ms", "%", "s");
  for (const std::string& path : paths) {
    const Recording recording = read_recording(path);
    print_row(recording, MotionModel::kRotation);
    print_row(recording, MotionModel::kAuto);
  }
  return 0;
}
