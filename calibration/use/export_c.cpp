// SPDX-License-Identifier: BSD-3-Clause
// A header in C99 (and C++) that needs nothing: arrays, and a function for each sensor.
#include <fmt/format.h>

#include <Eigen/LU>
#include <cctype>

#include "calibration/use/apply.h"
#include "calibration/use/export_text.h"

namespace magimu {
namespace {

std::string braced(const Vector3& v) {
  return fmt::format("{{MAGIMU_C({:.12g}), MAGIMU_C({:.12g}), MAGIMU_C({:.12g})}}", v[0] + 0.0,
                     v[1] + 0.0,
                     v[2] + 0.0);  // no -0
}

std::string rows(const Matrix3& m) {
  return fmt::format("{{{},\n    {},\n    {}}}", braced(m.row(0).transpose()),
                     braced(m.row(1).transpose()), braced(m.row(2).transpose()));
}

// Fit for the end of an identifier.
std::string identifier(const std::string& name) {
  std::string out;
  for (const char c : name) out += std::isalnum((unsigned char)(c)) != 0 ? c : '_';
  return out;
}

std::string sensor(const std::string& name, const Vector3& bias, const Matrix3& matrix,
                   const std::string& unit) {
  return fmt::format(
      R"c(
static const magimu_real magimu_{0}_bias[3] = {1}; /* {3} */
static const magimu_real magimu_{0}_matrix[3][3] = {{{2}}};
/* out = matrix (raw - bias); raw in {3}, out in {3}; both may be the same array. */
static inline void magimu_correct_{0}(const magimu_real raw[3], magimu_real out[3]) {{
  magimu_correct(magimu_{0}_matrix, magimu_{0}_bias, raw, out);
}}
)c",
      name, braced(bias), rows(matrix).substr(1, rows(matrix).size() - 2), unit);
}

constexpr const char* kBegin = R"c(#ifndef MAGIMU_CALIBRATION_H
#define MAGIMU_CALIBRATION_H

#ifdef MAGIMU_REAL /* for example float */
typedef MAGIMU_REAL magimu_real;
#else
typedef double magimu_real;
#endif
#define MAGIMU_C(x) ((magimu_real)(x)) /* no warning where it is float */

static inline void magimu_correct(const magimu_real matrix[3][3], const magimu_real bias[3],
                                  const magimu_real raw[3], magimu_real out[3]) {
  const magimu_real x = raw[0] - bias[0], y = raw[1] - bias[1], z = raw[2] - bias[2];
  int i;
  for (i = 0; i < 3; ++i) out[i] = matrix[i][0] * x + matrix[i][1] * y + matrix[i][2] * z;
}
)c";

}  // namespace

Exported export_c(const Calibration& c, const ExportOptions& options) {
  Exported out{"", lost_effects(c, {.matrices = true, .lag = true}), {}};
  std::string body = kBegin;
  body += sensor("acc", c.parameters.acc_bias, acc_correction(c), "m/s^2");
  body += sensor("gyr", c.parameters.gyr_bias, gyr_correction(c), "rad/s");
  for (std::size_t m = 0; m < c.mag_names.size(); ++m) {
    const std::string name = identifier(c.mag_names[m]);
    body += sensor(name, c.parameters.mag[m].bias, export_matrix(c, m, options), "uT");
    body += fmt::format(
        "/* s; a corrected reading shows the field so long before the gyroscope's time. */\n"
        "static const magimu_real magimu_{}_lag_s = MAGIMU_C({:.12g});\n",
        name, mag_lag_s(c, m));
  }
  body += fmt::format(
      "\n/* Length of a corrected magnetometer reading, uT; dip, degrees, down positive. */\n"
      "static const magimu_real magimu_field_strength_uT = MAGIMU_C({:.12g});\n"
      "static const magimu_real magimu_field_dip_deg = MAGIMU_C({:.12g});\n\n#undef "
      "MAGIMU_C\n#endif\n",
      export_strength_uT(c, options), c.parameters.dip_rad / kDegree);
  std::string head =
      comment_head(c, options,
                   {raw_units("uT", 1.0),
                    "Corrected readings are in the axes of the IMU, in m/s^2, rad/s and uT."},
                   out.lost, " *");
  for (auto at = head.find("*/"); at != std::string::npos; at = head.find("*/")) {
    head.insert(at + 1, " ");  // would end the comment
  }
  out.text = "/*\n" + head + " */\n" + body;
  return out;
}

}  // namespace magimu
