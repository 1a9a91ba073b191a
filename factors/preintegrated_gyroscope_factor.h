// SPDX-License-Identifier: BSD-3-Clause
// The gyroscope between two nodes any number of samples apart (Huang et al. 2025, eq. (MAP
// preintegration), third sum, and appendix C),
//
//   r = Log(Q),  Q = (delta Exp(J (o_w - bias)))' R_i' R_j
//
// with delta, J and the covariance from PreintegratedGyroscope. First order in o_w - bias: where
// the bias has moved far, integrate again.
#pragma once

#include "factors/preintegrated_gyroscope.h"
#include "graph/factor.h"

namespace magimu {

class PreintegratedGyroscopeFactor : public Factor<3, Rot3, Rot3, Vector3> {
 public:
  // density: gyroscope noise density, rad/s per sqrt(Hz).
  PreintegratedGyroscopeFactor(Key nRi, Key nRj, Key gyr_bias, const PreintegratedGyroscope& gyr,
                               double density)
      : Factor({nRi, nRj, gyr_bias}, Noise<3>::full(gyr.unit_covariance() * (density * density))),
        delta_(gyr.delta()),
        bias_(gyr.bias()),
        bias_jacobian_(gyr.bias_jacobian()) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRi, const Rot3T<T>& nRj, const Vec3<T>& gyr_bias) const {
    return prediction(gyr_bias).inverse_times(nRi, nRj).Log();
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRi, const Rot3T<T>& nRj, const Vec3<T>& gyr_bias,
                    Mat3<T>& J_Ri, Mat3<T>& J_Rj, Mat3<T>& J_bias) const {
    const Prediction<T> p = prediction(gyr_bias);
    const Rot3T<T> Q = p.inverse_times(nRi, nRj);
    Vec3<T> r = Q.Log();
    const Mat3<T> J = so3::right_jacobian_inverse(r);
    J_Rj = J * nRj.matrix().transpose();
    J_Ri = -J_Rj;
    J_bias = -(J * Q.matrix().transpose() * so3::right_jacobian(p.correction) *
               bias_jacobian_.cast<T>());
    return r;
  }

  // The bias at which the samples were integrated.
  const Vector3& integrated_at() const { return bias_; }

 private:
  template <class T>
  struct Prediction {
    Vec3<T> correction;  // J (o_w - bias)
    Rot3T<T> delta;
    Rot3T<T> inverse_times(const Rot3T<T>& nRi, const Rot3T<T>& nRj) const {
      return delta.inverse() * (nRi.inverse() * nRj);
    }
  };
  template <class T>
  Prediction<T> prediction(const Vec3<T>& gyr_bias) const {
    const Vec3<T> correction = bias_jacobian_.cast<T>() * (gyr_bias - bias_.cast<T>());
    return {correction, delta_.cast<T>() * Rot3T<T>::Exp(correction)};
  }

  Rot3 delta_;
  Vector3 bias_;
  Matrix3 bias_jacobian_;
};

}  // namespace magimu
