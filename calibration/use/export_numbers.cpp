// SPDX-License-Identifier: BSD-3-Clause
// The exports that hold any matrix: ROS parameters, a MATLAB script. Their conventions:
//
//   ROS     the magnetometer_pipeline of ctu-vras/compass, MagnetometerBiasRemover::removeBias():
//           scale * (field - bias), tesla (sensor_msgs/MagneticField), the parameters
//           initial_mag_bias_{x,y,z} and initial_mag_scaling_matrix, row by row
//   MATLAB  magcal (Navigation Toolbox): C = (D - b)*A with one reading a row; expmfs, uT
#include <fmt/format.h>

#include <Eigen/LU>

#include "calibration/use/apply.h"
#include "calibration/use/export_text.h"

namespace magimu {
namespace {

constexpr double kTesla = 1e6;  // uT

// With a point and an exponent: what both YAML and MATLAB read as a floating-point number.
std::string number(double value) { return fmt::format("{:.12e}", value + 0.0); }  // no -0

std::string list(const Vector3& v) {
  return number(v[0]) + ", " + number(v[1]) + ", " + number(v[2]);
}

std::string rows(const Matrix3& m, const std::string& between) {
  std::string out;
  for (int i = 0; i < 3; ++i) out += (i == 0 ? "" : between) + list(m.row(i).transpose());
  return out;
}

}  // namespace

Exported export_ros(const Calibration& c, const ExportOptions& options) {
  Exported out{"", lost_effects(c, {.matrices = true, .lag = true}), {}};
  std::string body;
  for (std::size_t m = 0; m < c.mag_names.size(); ++m) {
    const Vector3 bias = c.parameters.mag[m].bias / kTesla;
    // One magnetometer: whatever the node is called. Several: each by its name.
    body += c.mag_names.size() == 1 ? "/**:\n" : fmt::format("/**/{}:\n", c.mag_names[m]);
    body += "  ros__parameters:\n";
    for (int i = 0; i < 3; ++i) {
      body += fmt::format("    initial_mag_bias_{}: {}\n", "xyz"[i], number(bias[i]));
    }
    body += fmt::format("    initial_mag_scaling_matrix: [{}]\n",
                        rows(export_matrix(c, m, options), ",\n      "));
    if (m > 0) continue;
    body += fmt::format("    accelerometer_bias: [{}]\n    gyroscope_bias: [{}]\n",
                        list(c.parameters.acc_bias), list(c.parameters.gyr_bias));
    body += fmt::format("    accelerometer_scaling_matrix: [{}]\n",
                        rows(acc_correction(c), ",\n      "));
    body +=
        fmt::format("    gyroscope_scaling_matrix: [{}]\n", rows(gyr_correction(c), ",\n      "));
    body += fmt::format("    magnetometer_lag: {}\n", number(mag_lag_s(c, m)));
    body +=
        fmt::format("    field_strength: {}\n", number(export_strength_uT(c, options) / kTesla));
  }
  out.text =
      comment_head(
          c, options,
          {"Parameters for ROS 2 (ros2 run ... --ros-args --params-file FILE).",
           // NOLINTNEXTLINE(bugprone-suspicious-missing-comma): a sentence of two lines
           "initial_mag_*: those of magnetometer_bias_remover (package "
           "magnetometer_pipeline), field = matrix (raw - bias), tesla.",
           raw_units("tesla", kTesla),
           "The others, for your own node: acceleration = matrix (raw - bias), m/s^2; "
           "angular velocity = matrix (raw - bias), rad/s; lag in s; all in the axes of the IMU.",
           "For ROS 1 leave out the lines /**: and ros__parameters:."},
          out.lost, "#") +
      body;
  return out;
}

Exported export_matlab(const Calibration& c, const ExportOptions& options) {
  Exported out{"", lost_effects(c, {.matrices = true, .lag = true}), {}};
  std::string body;
  for (std::size_t m = 0; m < c.mag_names.size(); ++m) {
    const std::string suffix = c.mag_names.size() == 1 ? "" : fmt::format("{}", m + 1);
    body += fmt::format("A{} = [{}];\n", suffix,
                        rows(export_matrix(c, m, options).transpose(), "; ...\n     "));
    body += fmt::format("b{} = [{}];\n", suffix, list(c.parameters.mag[m].bias));
  }
  body += fmt::format("expmfs = {};  % uT\n", number(export_strength_uT(c, options)));
  body += fmt::format("acc_bias = [{}];\ngyr_bias = [{}];\n", list(c.parameters.acc_bias),
                      list(c.parameters.gyr_bias));
  body += fmt::format("acc_A = [{}];\n", rows(acc_correction(c).transpose(), "; ...\n     "));
  body += fmt::format("gyr_A = [{}];\n", rows(gyr_correction(c).transpose(), "; ...\n     "));
  for (std::size_t m = 0; m < c.mag_names.size(); ++m) {
    const std::string suffix = c.mag_names.size() == 1 ? "" : fmt::format("{}", m + 1);
    body += fmt::format("mag_lag{} = {};  % s\n", suffix, number(mag_lag_s(c, m)));
  }
  out.text = comment_head(c, options,
                          {"As magcal returns them: mag = (D - b)*A, one reading a row, uT, in the "
                           "axes of the IMU.",
                           "acc = (D - acc_bias)*acc_A, m/s^2; gyr = (D - gyr_bias)*gyr_A, rad/s.",
                           raw_units("uT", 1.0)},
                          out.lost, "%") +
             body;
  return out;
}

}  // namespace magimu
