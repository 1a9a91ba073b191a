// SPDX-License-Identifier: BSD-3-Clause
// A matrix that a sensor's readings are multiplied by, in words: most of what is wrong with a
// sensor that was mounted askew is one turn, of which nine numbers tell nobody anything.
#pragma once

#include <optional>
#include <string>

#include "graph/rot3.h"

namespace magimu {

// M = Q P, Q the nearest rotation (polar decomposition).
struct TurnAndRest {
  Vector3 turn = Vector3::Zero();  // of the sensor against its frame: Q' as a rotation vector, rad
  Vector3 sigma = Vector3::Zero();
  double scale = 1.0;  // cube root of det P
  double rest = 0.0;   // largest entry of P / scale - I, by its size
  double angle() const { return turn.norm(); }
};
// sigma: of M's entries. Empty where M is no rotation times a positive matrix.
std::optional<TurnAndRest> turn_and_rest(const Matrix3& M, const Matrix3& sigma = Matrix3::Zero());

// Is the turn beyond chance, and what most of M is?
bool is_mostly_a_turn(const TurnAndRest& t);

// "turned by 25.0 +- 0.1 deg about x", or "about (0.30, -0.52, 0.80)".
std::string turned_words(const TurnAndRest& t);

}  // namespace magimu
