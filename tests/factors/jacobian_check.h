// SPDX-License-Identifier: BSD-3-Clause
// The one check that every factor passes: analytic Jacobians against numerical and automatic ones,
// at random values.
#pragma once

#include <gtest/gtest.h>

#include <random>

#include "graph/checks/numerical_derivative.h"

namespace magimu::test {

class RandomValue {
 public:
  explicit RandomValue(unsigned seed) : engine_(seed) {}
  double number(double scale = 1.0) { return scale * normal_(engine_); }
  Vector3 vector3(double scale = 1.0) { return {number(scale), number(scale), number(scale)}; }
  Matrix3 matrix3(double scale = 1.0) {
    return Matrix3::NullaryExpr([&] { return number(scale); });
  }
  // Uniform over all rotations.
  Rot3 rotation() { return Rot3::from_quaternion(Vector4(number(), number(), number(), number())); }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

template <class F>
void expect_correct_jacobians(const F& factor, const Values& values) {
  const JacobianCheck check = check_jacobians(factor, values);
  EXPECT_TRUE(check.analytic) << "linearize() has not the signature that graph/factor.h asks for";
  EXPECT_LT(check.numerical_error, 1e-8);
  EXPECT_LT(check.automatic_error, 1e-12);
  EXPECT_LT(check.residual_error, 1e-13);
}

}  // namespace magimu::test
