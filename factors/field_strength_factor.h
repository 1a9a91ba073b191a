// SPDX-License-Identifier: BSD-3-Clause
// The field's strength s_0 is known beforehand, and D's volume is its cube:
//
//   r = (det D - s_0^3) / (3 s_0^2)          near the solution: the strength less s_0, uT
#pragma once

#include "graph/factor.h"

namespace magimu {

class FieldStrengthFactor : public Factor<1, Matrix3> {
 public:
  FieldStrengthFactor(Key distortion, double strength_uT, const Noise<1>& noise)
      : Factor({distortion}, noise), strength_uT_(strength_uT) {}

  template <class T>
  Vec<T, 1> residual(const Mat3<T>& D) const {
    const double s = strength_uT_;
    const T det = D.col(0).dot(D.col(1).cross(D.col(2)));
    return Vec<T, 1>((det - T(s * s * s)) * T(1.0 / (3.0 * s * s)));
  }

  // The gradient of a determinant: each column's is the product of the other two.
  template <class T>
  Vec<T, 1> linearize(const Mat3<T>& D, Mat<T, 1, 9>& J) const {
    const T scale(1.0 / (3.0 * strength_uT_ * strength_uT_));
    const Vec3<T> x = D.col(0), y = D.col(1), z = D.col(2);
    J.template block<1, 3>(0, 0) = scale * y.cross(z).transpose();
    J.template block<1, 3>(0, 3) = scale * z.cross(x).transpose();
    J.template block<1, 3>(0, 6) = scale * x.cross(y).transpose();
    return residual<T>(D);
  }

 private:
  double strength_uT_;
};

}  // namespace magimu
