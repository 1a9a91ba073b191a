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

template <class S>
class PreintegratedGyroscopeText {
 public:
  PreintegratedGyroscopeText(const Rot3T<S>& delta, const Vec3<S>& bias,
                             const Mat3<S>& bias_jacobian)
      : delta_(delta), bias_(bias), bias_jacobian_(bias_jacobian) {}

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
               bias_jacobian_.template cast<T>());
    return r;
  }

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
    const Vec3<T> correction =
        bias_jacobian_.template cast<T>() * (gyr_bias - bias_.template cast<T>());
    return {correction, delta_.template cast<T>() * Rot3T<T>::Exp(correction)};
  }

  Rot3T<S> delta_;
  Vec3<S> bias_;
  Mat3<S> bias_jacobian_;
};

class PreintegratedGyroscopeFactor : public Factor<3, Rot3, Rot3, Vector3>,
                                     public PreintegratedGyroscopeText<double> {
 public:
  template <class S>
  using Text = PreintegratedGyroscopeText<S>;

  // density: gyroscope noise density, rad/s per sqrt(Hz).
  PreintegratedGyroscopeFactor(Key nRi, Key nRj, Key gyr_bias, const PreintegratedGyroscope& gyr,
                               double density)
      : Factor({nRi, nRj, gyr_bias}, Noise<3>::full(gyr.unit_covariance() * (density * density))),
        PreintegratedGyroscopeText(gyr.delta(), gyr.bias(), gyr.bias_jacobian()) {}
};
template <>
inline constexpr bool kHasLanes<PreintegratedGyroscopeFactor> = true;

}  // namespace magimu
