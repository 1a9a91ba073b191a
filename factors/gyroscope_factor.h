// SPDX-License-Identifier: BSD-3-Clause
// The gyroscope between two neighbouring poses, one sample (third sum of the cost, Huang et al.
// 2025, eq. (original MAP)),
//
//   r = gyr - Log(R_k' R_k+1) / dt - o_w
#pragma once

#include "graph/factor_graph.h"

namespace magimu {

template <class S>
class GyroscopeText {
 public:
  GyroscopeText(const Vec3<S>& gyr, const S& rate_hz) : gyr_(gyr), rate_hz_(rate_hz) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Rot3T<T>& nRb_next, const Vec3<T>& gyr_bias) const {
    return gyr_.template cast<T>() - (nRb.inverse() * nRb_next).Log() * T(rate_hz_) - gyr_bias;
  }

  // Appendix B: d r / d R_k = J_r^-1(phi) R_k+1' / dt, d r / d R_k+1 the negative, d r / d o_w =
  // -I.
  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Rot3T<T>& nRb_next, const Vec3<T>& gyr_bias,
                    Mat3<T>& J_R, Mat3<T>& J_R_next, Mat3<T>& J_bias) const {
    const T rate(rate_hz_);
    const Vec3<T> phi = (nRb.inverse() * nRb_next).Log();
    J_R = so3::right_jacobian_inverse(phi) * nRb_next.matrix().transpose() * rate;
    J_R_next = -J_R;
    J_bias = -Mat3<T>::Identity();
    return gyr_.template cast<T>() - phi * rate - gyr_bias;
  }

  static constexpr bool is_zero(int row, int column) { return column >= 6 && column % 3 != row; }

 private:
  Vec3<S> gyr_;
  S rate_hz_;
};

class GyroscopeFactor : public Factor<3, Rot3, Rot3, Vector3>, public GyroscopeText<double> {
 public:
  template <class S>
  using Text = GyroscopeText<S>;

  // gyr: mean rate over the interval of dt_s seconds between the two poses, rad/s, IMU frame.
  GyroscopeFactor(Key nRb, Key nRb_next, Key gyr_bias, const Vector3& gyr, double dt_s,
                  const Noise<3>& noise)
      : Factor({nRb, nRb_next, gyr_bias}, noise), GyroscopeText(gyr, 1.0 / dt_s) {}
};
template <>
inline constexpr bool kHasLanes<GyroscopeFactor> = true;

// Compiled once, in factors.cpp.
extern template class FactorBatchOf<GyroscopeFactor>;

}  // namespace magimu
