// SPDX-License-Identifier: BSD-3-Clause
// Extrinsic alignment (Wu et al. 2016): in a homogeneous field the direction that the magnetometer
// sees changes only because the sensor turns, and the gyroscope measures that turn. Between two
// times,
//
//   r = u_j - mRb delta' mRb' u_i,   delta = b_i R b_j as preintegrated, corrected for the bias,
//
// with u unit field directions in the magnetometer's (intrinsically calibrated) frame and mRb the
// rotation from the IMU frame to it: the R_D of D = D_I R_D.
#pragma once

#include "factors/preintegrated_gyroscope.h"
#include "graph/factor.h"

namespace magimu {

class FieldRotationFactor : public Factor<3, Rot3, Vector3> {
 public:
  FieldRotationFactor(Key mRb, Key gyr_bias, const Vector3& u_i, const Vector3& u_j,
                      const PreintegratedGyroscope& gyr, const Noise<3>& noise)
      : Factor({mRb, gyr_bias}, noise), u_i_(u_i), u_j_(u_j), gyr_(gyr) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& mRb, const Vec3<T>& gyr_bias) const {
    const Vec3<T> turned = delta(gyr_bias).unrotate(mRb.unrotate(Vec3<T>(u_i_.cast<T>())));
    return u_j_.cast<T>() - mRb * turned;
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& mRb, const Vec3<T>& gyr_bias, Mat3<T>& J_R,
                    Mat3<T>& J_bias) const {
    const Mat3<T> M = mRb.matrix();
    const Vec3<T> u = u_i_.cast<T>();
    const Mat3<T> delta_T = delta(gyr_bias).matrix().transpose();
    const Vec3<T> turned = delta_T * (M.transpose() * u);
    const Vec3<T> predicted = M * turned;
    // M <- Exp(d) M: predicted + d x predicted - M delta' M' (d x u)
    J_R = so3::hat(predicted) - M * delta_T * M.transpose() * so3::hat(u);
    // delta <- delta Exp(e): delta' <- Exp(-e) delta'
    const Vec3<T> correction = gyr_.bias_jacobian().cast<T>() * (gyr_bias - gyr_.bias().cast<T>());
    J_bias =
        -(M * so3::hat(turned) * so3::right_jacobian(correction) * gyr_.bias_jacobian().cast<T>());
    return u_j_.cast<T>() - predicted;
  }

 private:
  template <class T>
  Rot3T<T> delta(const Vec3<T>& gyr_bias) const {
    const Vec3<T> e = gyr_.bias_jacobian().cast<T>() * (gyr_bias - gyr_.bias().cast<T>());
    return gyr_.delta().cast<T>() * Rot3T<T>::Exp(e);
  }

  Vector3 u_i_, u_j_;
  PreintegratedGyroscope gyr_;
};

}  // namespace magimu
