// SPDX-License-Identifier: BSD-3-Clause
// Unit vectors in which to try every property of rotations: along all axes, edges and corners of
// the cube, where signs and zeros are special, and some without any symmetry.
#pragma once

#include <vector>

#include "tests/factors/jacobian_check.h"

namespace magimu::test {

inline constexpr double kPi = 3.141592653589793;  // rounded down: below the true pi by 1.2e-16

inline std::vector<Vector3> directions() {
  std::vector<Vector3> out;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x != 0 || y != 0 || z != 0) out.push_back(Vector3(x, y, z).normalized());
      }
    }
  }
  RandomValue random(1);
  for (int i = 0; i < 20; ++i) out.push_back(random.vector3().normalized());
  return out;
}

}  // namespace magimu::test
