// SPDX-License-Identifier: BSD-3-Clause
// The calculus of rotations, SO(3): hat, the exponential, the logarithm and their Jacobians, exact
// (to rounding) from angle 0 to pi. Closed forms lose digits where the angle is small; there the
// power series in theta^2 serves. Both are always evaluated (see scalar.h), the closed form on a
// safe argument.
//
//   Exp(v + dv) ~ Exp(v) Exp(J_r(v) dv)      Log(R Exp(dv)) ~ Log(R) + J_r^-1(Log R) dv
//   J_l(v) = J_r(-v)
#pragma once

#include "graph/scalar.h"

namespace magimu::so3 {

// Below this theta^2 the series below are exact to rounding.
inline constexpr double kSeriesBelow = 0.1;

template <class T>
Mat3<T> hat(const Vec3<T>& v) {
  Mat3<T> m;
  const T zero(0.0);
  m << zero, -v[2], v[1], v[2], zero, -v[0], -v[1], v[0], zero;
  return m;
}

// (1 - cos theta) / theta^2, from theta^2.
template <class T>
T cosine_ratio(const T& t2) {
  using std::cos, std::sqrt;
  const auto small = t2 < kSeriesBelow;
  const T safe = select(small, T(1.0), t2);
  const T closed = (T(1.0) - cos(sqrt(safe))) / safe;
  const T series =
      T(0.5) -
      t2 * (1.0 / 24 -
            t2 * (1.0 / 720 - t2 * (1.0 / 40320 - t2 * (1.0 / 3628800 - t2 * (1.0 / 479001600)))));
  return select(small, series, closed);
}

// (theta - sin theta) / theta^3, from theta^2.
template <class T>
T sine_ratio(const T& t2) {
  using std::sin, std::sqrt;
  const auto small = t2 < kSeriesBelow;
  const T safe = select(small, T(1.0), t2);
  const T theta = sqrt(safe);
  const T closed = (theta - sin(theta)) / (safe * theta);
  const T series =
      T(1.0 / 6) -
      t2 * (1.0 / 120 -
            t2 * (1.0 / 5040 - t2 * (1.0 / 362880 - t2 * (1.0 / 39916800 - t2 / 6227020800.0))));
  return select(small, series, closed);
}

// (1 - (theta/2) cot(theta/2)) / theta^2, from theta^2; finite up to theta = 2 pi.
template <class T>
T cotangent_ratio(const T& t2) {
  using std::cos, std::sin, std::sqrt;
  const auto small = t2 < kSeriesBelow;
  const T safe = select(small, T(1.0), t2);
  const T half = T(0.5) * sqrt(safe);
  const T closed = (T(1.0) - half * cos(half) / sin(half)) / safe;
  const T series =
      T(1.0 / 12) +
      t2 * (1.0 / 720 +
            t2 * (1.0 / 30240 +
                  t2 * (1.0 / 1209600 + t2 * (1.0 / 47900160 + t2 * (691.0 / 1307674368000)))));
  return select(small, series, closed);
}

// Right Jacobian of SO(3): J_r(v) = I - (1-cos)/theta^2 [v] + (theta-sin)/theta^3 [v]^2.
template <class T>
Mat3<T> right_jacobian(const Vec3<T>& v) {
  const T t2 = v.dot(v);
  const Mat3<T> V = hat(v);
  Mat3<T> J = V * V * sine_ratio(t2) - V * cosine_ratio(t2);
  for (int i = 0; i < 3; ++i) J(i, i) += T(1.0);
  return J;
}

// Inverse of right_jacobian: I + [v]/2 + (1 - (theta/2) cot(theta/2))/theta^2 [v]^2.
template <class T>
Mat3<T> right_jacobian_inverse(const Vec3<T>& v) {
  const T t2 = v.dot(v);
  const Mat3<T> V = hat(v);
  Mat3<T> J = V * V * cotangent_ratio(t2) + V * T(0.5);
  for (int i = 0; i < 3; ++i) J(i, i) += T(1.0);
  return J;
}

template <class T>
Mat3<T> left_jacobian(const Vec3<T>& v) {
  return right_jacobian<T>(-v);
}

template <class T>
Mat3<T> left_jacobian_inverse(const Vec3<T>& v) {
  return right_jacobian_inverse<T>(-v);
}

}  // namespace magimu::so3
