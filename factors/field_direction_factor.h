// SPDX-License-Identifier: BSD-3-Clause
// One magnetometer reading of intrinsic calibration (Huang et al. 2025, eq. (intrinsic
// calibration)): r = mag - L u - o_m, with L lower triangular and u a free unit vector, held as two
// coordinates in the plane that touches the sphere at a given base point:
//
//   u = (base + B w) / |base + B w|,   B: two unit vectors orthogonal to base.
//
// Regular within 90 degrees of the base, wherever on the sphere that is.
#pragma once

#include "graph/factor.h"

namespace magimu {

class FieldDirectionFactor : public Factor<3, Vec<double, 6>, Vector3, Vector2> {
 public:
  // lower: the six entries of L, column by column. base: unit vector near u.
  FieldDirectionFactor(Key lower, Key mag_bias, Key direction, const Vector3& mag_uT,
                       const Vector3& base, const Noise<3>& noise)
      : Factor({lower, mag_bias, direction}, noise), mag_(mag_uT), base_(base) {
    Eigen::Index smallest = 0;
    base.cwiseAbs().minCoeff(&smallest);
    plane_.col(0) = base.cross(Vector3::Unit(smallest)).normalized();
    plane_.col(1) = base.cross(plane_.col(0));
  }

  template <class T>
  Vec3<T> residual(const Vec<T, 6>& l, const Vec3<T>& mag_bias, const Vec<T, 2>& w) const {
    using std::sqrt;
    const Vec3<T> p = base_.cast<T>() + plane_.cast<T>() * w;
    return mag_.cast<T>() - lower(l) * p * (T(1.0) / sqrt(p.dot(p))) - mag_bias;
  }

  template <class T>
  Vec3<T> linearize(const Vec<T, 6>& l, const Vec3<T>& mag_bias, const Vec<T, 2>& w,
                    Mat<T, 3, 6>& J_l, Mat3<T>& J_bias, Mat<T, 3, 2>& J_w) const {
    using std::sqrt;
    const Vec3<T> p = base_.cast<T>() + plane_.cast<T>() * w;
    const T inverse = T(1.0) / sqrt(p.dot(p));
    const Vec3<T> u = p * inverse;
    const Mat3<T> L = lower(l);
    J_l.setZero();
    J_l(0, 0) = J_l(1, 1) = J_l(2, 2) = -u[0];
    J_l(1, 3) = J_l(2, 4) = -u[1];
    J_l(2, 5) = -u[2];
    J_bias = -Mat3<T>::Identity();
    const Mat3<T> tangent = (Mat3<T>::Identity() - u * u.transpose()) * inverse;
    J_w = -(L * tangent * plane_.cast<T>());
    return mag_.cast<T>() - L * u - mag_bias;
  }

  // The matrix of six entries, column by column.
  template <class T>
  static Mat3<T> lower(const Vec<T, 6>& l) {
    Mat3<T> L;
    const T zero(0.0);
    L << l[0], zero, zero, l[1], l[3], zero, l[2], l[4], l[5];
    return L;
  }

 private:
  Vector3 mag_, base_;
  Mat<double, 3, 2> plane_;
};

}  // namespace magimu
