// SPDX-License-Identifier: BSD-3-Clause
// A magnetometer whose readings show the attitude some time ago: mag = h(t - tau). The mean of a
// block of samples about a node,
//
//   r = mag - D (C + C' (tau - tau_0)) R' m(alpha) - o_m
//
// with C the mean rotation from the node to the samples' times less tau_0 and C' its derivative
// with respect to tau, both through the gyroscope (block_means.h). Exact at tau = tau_0: rebuild
// there as the estimate moves.
#pragma once

#include "factors/magnetometer_factor.h"

namespace magimu {

template <class S>
class DelayedMagnetometerText {
 public:
  DelayedMagnetometerText(const Vec3<S>& mag, const Mat3<S>& C, const Mat3<S>& C_rate,
                          const S& offset_s)
      : mag_(mag), C_(C), C_rate_(C_rate), offset_s_(offset_s) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Mat3<T>& D, const Vec3<T>& mag_bias, const T& dip_rad,
                   const T& offset_s) const {
    const Vec3<T> b = C(offset_s) * nRb.unrotate(unit_field(dip_rad));
    return mag_.template cast<T>() - D * b - mag_bias;
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Mat3<T>& D, const Vec3<T>& mag_bias,
                    const T& dip_rad, const T& offset_s, Mat3<T>& J_R, Mat<T, 3, 9>& J_D,
                    Mat3<T>& J_bias, Vec3<T>& J_dip, Vec3<T>& J_offset) const {
    const Mat3<T> bRn = nRb.matrix().transpose();
    const Mat3<T> CbRn = C(offset_s) * bRn;
    J_offset = -(D * (C_rate_.template cast<T>() * (bRn * unit_field(dip_rad))));
    return detail::linearize_magnetometer<T>(mag_.template cast<T>(), CbRn, D, mag_bias, dip_rad,
                                             J_R, J_D, J_bias, J_dip);
  }

  static constexpr bool is_zero(int row, int column) {
    return detail::magnetometer_is_zero(row, column);
  }

 private:
  template <class T>
  Mat3<T> C(const T& offset_s) const {
    return C_.template cast<T>() + C_rate_.template cast<T>() * (offset_s - T(offset_s_));
  }

  Vec3<S> mag_;
  Mat3<S> C_, C_rate_;
  S offset_s_;
};

class DelayedMagnetometerFactor : public Factor<3, Rot3, Matrix3, Vector3, double, double>,
                                  public DelayedMagnetometerText<double> {
 public:
  template <class S>
  using Text = DelayedMagnetometerText<S>;

  // offset: the key of tau, s; C, C_rate, offset_s: as above.
  DelayedMagnetometerFactor(Key nRb, Key distortion, Key mag_bias, Key dip, Key offset,
                            const Vector3& mag, const Matrix3& C, const Matrix3& C_rate,
                            double offset_s, const Noise<3>& noise)
      : Factor({nRb, distortion, mag_bias, dip, offset}, noise),
        DelayedMagnetometerText(mag, C, C_rate, offset_s) {}
};
template <>
inline constexpr bool kHasLanes<DelayedMagnetometerFactor> = true;

}  // namespace magimu
