// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/result/gyr_matrix.h"

namespace magimu {

Matrix3 gyr_matrix(const Calibration& c) {
  Matrix3 M = Matrix3::Identity();
  for (const ActiveEffect& effect : c.effects) {
    if (effect.name != "gyro_scale_misalignment" || effect.parameters.size() != 9) continue;
    for (std::size_t i = 0; i < 9; ++i) {
      M(Eigen::Index(i / 3), Eigen::Index(i % 3)) += effect.parameters[i].value;
    }
  }
  return M;
}

}  // namespace magimu
