// SPDX-License-Identifier: BSD-3-Clause
// A rotation, held as a unit quaternion (w, x, y, z): the logarithm is then exact from angle 0 to
// pi without cases on matrix entries. As an unknown of the graph it is perturbed from the left,
// R <- Exp(delta) R (Huang et al. 2025, appendix A), and renormalized at every update.
// A name such as nRb is read "n from b": it turns vectors of frame b into frame n.
#pragma once

#include <Eigen/Geometry>
#include <stdexcept>
#include <type_traits>

#include "graph/so3.h"

namespace magimu {

template <class T>
class Rot3T {
 public:
  Rot3T() : q_(T(1.0), T(0.0), T(0.0), T(0.0)) {}

  // From a unit quaternion (w, x, y, z); the caller vouches for its norm.
  static Rot3T from_unit_quaternion(const Vec<T, 4>& wxyz) {
    Rot3T R;
    R.q_ = wxyz;
    return R;
  }
  // From any non-zero quaternion (w, x, y, z).
  static Rot3T from_quaternion(const Vec<T, 4>& wxyz) {
    using std::sqrt;
    return from_unit_quaternion(wxyz / sqrt(wxyz.dot(wxyz)));
  }
  // From a rotation matrix. Throws std::invalid_argument where m of double is none: its columns are
  // not orthonormal to within 0.01 (rounded data sheets are), or it is a reflection.
  static Rot3T from_matrix(const Mat3<T>& m) {
    if constexpr (std::is_same_v<T, double>) {
      const double off = (m.transpose() * m - Mat3<T>::Identity()).cwiseAbs().maxCoeff();
      if (!(off < 0.01) || m.determinant() < 0.0) {
        throw std::invalid_argument(
            "Rot3::from_matrix: this matrix is no rotation: its columns are not orthonormal, or "
            "they "
            "are left-handed");
      }
    }
    const Eigen::Quaternion<T> q(m);
    return from_quaternion(Vec<T, 4>(q.w(), q.x(), q.y(), q.z()));
  }

  // The rotation by |v| radians about v.
  static Rot3T Exp(const Vec3<T>& v) {
    using std::cos, std::sin, std::sqrt;
    const T t2 = v.dot(v);
    const auto small = t2 < 1e-3;
    const T half = T(0.5) * sqrt(select(small, T(1.0), t2));
    const T x = t2 * T(0.25);  // (theta / 2)^2, for the series
    const T s = select(small, T(0.5) * (T(1.0) - x * (1.0 / 6 - x * (1.0 / 120 - x / 5040.0))),
                       T(0.5) * sin(half) / half);
    const T c = select(small, T(1.0) - x * (0.5 - x * (1.0 / 24 - x * (1.0 / 720 - x / 40320.0))),
                       cos(half));
    return from_unit_quaternion(Vec<T, 4>(c, s * v[0], s * v[1], s * v[2]));
  }

  // The rotation vector of length at most pi; Exp(Log(R)) = R.
  Vec3<T> Log() const {
    using std::atan2, std::sqrt;
    const T sign = select(q_[0] < T(0.0), T(-1.0), T(1.0));
    const T w = sign * q_[0];
    const T n2 = q_[1] * q_[1] + q_[2] * q_[2] + q_[3] * q_[3];
    const auto small = n2 < 1e-6;
    const T safe_w = select(small, w, T(1.0));  // near the identity w is near 1
    const T safe_n = sqrt(select(small, T(1.0), n2));
    const T x = n2 / (safe_w * safe_w);
    const T series = T(2.0) / safe_w * (T(1.0) - x * (1.0 / 3 - x * (1.0 / 5 - x / 7.0)));
    const T closed = T(2.0) * atan2(safe_n, w) / safe_n;
    return Vec3<T>(q_[1], q_[2], q_[3]) * (sign * select(small, series, closed));
  }

  Mat3<T> matrix() const {
    const T w = q_[0], x = q_[1], y = q_[2], z = q_[3];
    const T two(2.0), one(1.0);
    Mat3<T> m;
    m << one - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y),
        two * (x * y + w * z), one - two * (x * x + z * z), two * (y * z - w * x),
        two * (x * z - w * y), two * (y * z + w * x), one - two * (x * x + y * y);
    return m;
  }

  Rot3T inverse() const { return from_unit_quaternion(Vec<T, 4>(q_[0], -q_[1], -q_[2], -q_[3])); }

  Rot3T operator*(const Rot3T& o) const {
    const Vec<T, 4>& a = q_;
    const Vec<T, 4>& b = o.q_;
    return from_unit_quaternion(Vec<T, 4>(a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                                          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                                          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                                          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]));
  }
  Vec3<T> operator*(const Vec3<T>& v) const { return matrix() * v; }
  // R^T v, without forming the inverse.
  Vec3<T> unrotate(const Vec3<T>& v) const { return matrix().transpose() * v; }

  Rot3T normalized() const { return from_quaternion(q_); }
  const Vec<T, 4>& quaternion() const { return q_; }

  template <class U>
  Rot3T<U> cast() const {
    return Rot3T<U>::from_unit_quaternion(q_.template cast<U>());
  }

 private:
  Vec<T, 4> q_;
};

using Rot3 = Rot3T<double>;

}  // namespace magimu
