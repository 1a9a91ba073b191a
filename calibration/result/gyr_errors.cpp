// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/result/gyr_errors.h"

namespace magimu {

Matrix3 gyr_errors(const Calibration& c) {
  Matrix3 S = Matrix3::Zero();
  for (const ActiveEffect& effect : c.effects) {
    if (effect.name != "gyro_scale_misalignment" || effect.parameters.size() != 9) continue;
    for (std::size_t i = 0; i < 9; ++i) {
      S(Eigen::Index(i / 3), Eigen::Index(i % 3)) += effect.parameters[i].value;
    }
  }
  return S;
}

}  // namespace magimu
