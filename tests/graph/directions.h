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
  for (int i = 0; i < 27; ++i) {
    const Vector3 n(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (i != 13) out.push_back(n.normalized());
  }
  RandomValue random(1);
  for (int i = 0; i < 20; ++i) out.push_back(random.vector3().normalized());
  return out;
}

}  // namespace magimu::test
