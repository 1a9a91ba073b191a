// SPDX-License-Identifier: BSD-3-Clause
// The magnetometer: the local field seen through distortion matrix, bias and dip (second sum of
// the cost, Huang et al. 2025, eq. (original MAP)),
//
//   r = mag - D C R' m(alpha) - o_m        C = I for one sample.
//
// For the mean over a block of samples C is the mean of the rotations from the node to the samples
// (block_means.h).
#pragma once

#include "factors/sensor_model.h"
#include "graph/factor_graph.h"

namespace magimu {

namespace detail {

// Jacobians of r = mag - D b - o_m, b = Cb R' m(alpha), shared by both factors (appendix B).
template <class T>
Vec3<T> linearize_magnetometer(const Vec3<T>& mag, const Mat3<T>& CbRn, const Mat3<T>& D,
                               const Vec3<T>& mag_bias, const T& dip_rad, Mat3<T>& J_R,
                               Mat<T, 3, 9>& J_D, Mat3<T>& J_bias, Vec3<T>& J_dip) {
  using std::cos, std::sin;
  const T c = cos(dip_rad), s = sin(dip_rad);
  const Vec3<T> b = CbRn.col(1) * c - CbRn.col(2) * s;
  const Mat3<T> DCbRn = D * CbRn;
  // -D R' [m]x with m = (0, c, -s): [m]x has the columns (0, -s, -c), (s, 0, 0), (c, 0, 0).
  J_R.col(0) = DCbRn.col(1) * s + DCbRn.col(2) * c;
  J_R.col(1) = DCbRn.col(0) * -s;
  J_R.col(2) = DCbRn.col(0) * -c;
  J_D.setZero();  // -b' (x) I, D taken column by column
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) J_D(i, 3 * j + i) = -b[j];
  }
  J_bias = -Mat3<T>::Identity();
  J_dip = DCbRn.col(1) * s + DCbRn.col(2) * c;
  return mag - D * b - mag_bias;
}

// A row of D and an entry of o_m tell of one row of the residual.
constexpr bool magnetometer_is_zero(int row, int column) {
  return column >= 3 && column < 15 && column % 3 != row;
}

}  // namespace detail

template <class S>
class MagnetometerText {
 public:
  explicit MagnetometerText(const Vec3<S>& mag) : mag_(mag) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Mat3<T>& D, const Vec3<T>& mag_bias,
                   const T& dip_rad) const {
    return mag_.template cast<T>() - magnetometer_model(nRb, D, mag_bias, dip_rad);
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Mat3<T>& D, const Vec3<T>& mag_bias,
                    const T& dip_rad, Mat3<T>& J_R, Mat<T, 3, 9>& J_D, Mat3<T>& J_bias,
                    Vec3<T>& J_dip) const {
    return detail::linearize_magnetometer<T>(mag_.template cast<T>(), nRb.matrix().transpose(), D,
                                             mag_bias, dip_rad, J_R, J_D, J_bias, J_dip);
  }

  static constexpr bool is_zero(int row, int column) {
    return detail::magnetometer_is_zero(row, column);
  }

 private:
  Vec3<S> mag_;
};

class MagnetometerFactor : public Factor<3, Rot3, Matrix3, Vector3, double>,
                           public MagnetometerText<double> {
 public:
  template <class S>
  using Text = MagnetometerText<S>;

  // mag: uT, in the magnetometer's axes.
  MagnetometerFactor(Key nRb, Key distortion, Key mag_bias, Key dip, const Vector3& mag,
                     const Noise<3>& noise)
      : Factor({nRb, distortion, mag_bias, dip}, noise), MagnetometerText(mag) {}
};
template <>
inline constexpr bool kHasLanes<MagnetometerFactor> = true;

template <class S>
class MeanMagnetometerText {
 public:
  MeanMagnetometerText(const Vec3<S>& mag, const Mat3<S>& C) : mag_(mag), C_(C) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Mat3<T>& D, const Vec3<T>& mag_bias,
                   const T& dip_rad) const {
    const Vec3<T> b = C_.template cast<T>() * nRb.unrotate(unit_field(dip_rad));
    return mag_.template cast<T>() - D * b - mag_bias;
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Mat3<T>& D, const Vec3<T>& mag_bias,
                    const T& dip_rad, Mat3<T>& J_R, Mat<T, 3, 9>& J_D, Mat3<T>& J_bias,
                    Vec3<T>& J_dip) const {
    return detail::linearize_magnetometer<T>(mag_.template cast<T>(),
                                             C_.template cast<T>() * nRb.matrix().transpose(), D,
                                             mag_bias, dip_rad, J_R, J_D, J_bias, J_dip);
  }

  static constexpr bool is_zero(int row, int column) {
    return detail::magnetometer_is_zero(row, column);
  }

 private:
  Vec3<S> mag_;
  Mat3<S> C_;
};

class MeanMagnetometerFactor : public Factor<3, Rot3, Matrix3, Vector3, double>,
                               public MeanMagnetometerText<double> {
 public:
  template <class S>
  using Text = MeanMagnetometerText<S>;

  // mag: the block's mean; C: mean rotation from the node's IMU frame to that of the samples.
  MeanMagnetometerFactor(Key nRb, Key distortion, Key mag_bias, Key dip, const Vector3& mag,
                         const Matrix3& C, const Noise<3>& noise)
      : Factor({nRb, distortion, mag_bias, dip}, noise), MeanMagnetometerText(mag, C) {}
};
template <>
inline constexpr bool kHasLanes<MeanMagnetometerFactor> = true;

// The same beside a field that differs from place to place: it sees the position of its node, too,
//
//   r = mag - D C R' m(alpha) - o_m - B (p - p_0)
//
// with mag less what the place's field adds at p_0, and B what that changes by there.
class PlacedMagnetometerFactor : public Factor<3, Rot3, Matrix3, Vector3, double, Vector3> {
 public:
  // by_position: B, uT/m, in the magnetometer's axes.
  PlacedMagnetometerFactor(Key nRb, Key distortion, Key mag_bias, Key dip, Key position,
                           const Vector3& mag, const Matrix3& C, const Vector3& at,
                           const Matrix3& by_position, const Noise<3>& noise)
      : Factor({nRb, distortion, mag_bias, dip, position}, noise),
        mean_(mag, C),
        at_(at),
        by_position_(by_position) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Mat3<T>& D, const Vec3<T>& mag_bias, const T& dip_rad,
                   const Vec3<T>& position) const {
    return mean_.residual(nRb, D, mag_bias, dip_rad) -
           by_position_.template cast<T>() * (position - at_.template cast<T>());
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Mat3<T>& D, const Vec3<T>& mag_bias,
                    const T& dip_rad, const Vec3<T>& position, Mat3<T>& J_R, Mat<T, 3, 9>& J_D,
                    Mat3<T>& J_bias, Vec3<T>& J_dip, Mat3<T>& J_position) const {
    J_position = -by_position_.template cast<T>();
    return mean_.linearize(nRb, D, mag_bias, dip_rad, J_R, J_D, J_bias, J_dip) +
           J_position * (position - at_.template cast<T>());
  }

 private:
  MeanMagnetometerText<double> mean_;
  Vector3 at_;
  Matrix3 by_position_;
};

// Compiled once, in factors.cpp.
extern template class FactorBatchOf<MagnetometerFactor>;

}  // namespace magimu
