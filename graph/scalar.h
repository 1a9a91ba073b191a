// SPDX-License-Identifier: BSD-3-Clause
// The vocabulary of templated residuals: fixed-size vectors and matrices over any scalar T, and
// `select`. A residual written with these serves double, automatic differentiation (dual.h) and
// SIMD packs alike, because it never branches on a value: both sides of a `select` are evaluated,
// so the side not taken must be finite too (feed it a safe argument).
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace magimu {

template <class T, int R, int C>
using Mat = Eigen::Matrix<T, R, C>;
template <class T, int N>
using Vec = Eigen::Matrix<T, N, 1>;
template <class T>
using Vec3 = Vec<T, 3>;
template <class T>
using Mat3 = Mat<T, 3, 3>;

using Vector2 = Vec<double, 2>;
using Vector3 = Vec<double, 3>;
using Vector4 = Vec<double, 4>;
using Matrix3 = Mat<double, 3, 3>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// condition ? a : b, without a branch where T is a pack.
inline double select(bool condition, double a, double b) { return condition ? a : b; }

// The value behind a scalar, for decisions that are not part of the residual (tests, messages).
inline double value_of(double x) { return x; }

}  // namespace magimu
