// SPDX-License-Identifier: BSD-3-Clause
// A hand moves the sensor: accelerometer and gyroscope between two nodes (R, v, p),
//
//   r_R = Log((delta_R Exp(d_R))' R_i' R_j)
//   r_v = R_i' (v_j - v_i - g h)                   - (delta_v + d_v)
//   r_p = R_i' (p_j - p_i - v_i h - g h^2 / 2)     - (delta_p + d_p)
//
// with g gravity in n and d = (d_R, d_v, d_p) what changes in the integrated quantities with the
// biases (and the gyroscope's matrix S), by their distance from where the samples were integrated
// (PreintegratedImu; Forster et al. 2016, eq. 44-45). First order: integrate again where the
// distance is large.
#pragma once

#include "factors/preintegrated_imu.h"
#include "graph/factor.h"

namespace magimu {

namespace detail {

// What the factors below share: the residual for a given d, and its Jacobians.
template <class S>
class ImuText {
  template <class T>
  using M93 = Mat<T, 9, 3>;

 public:
  ImuText(const PreintegratedImu& imu, const Vector3& g_n)
      : delta_R_(imu.delta_R()),
        gyr_jacobian_(imu.gyr_bias_jacobian()),
        acc_jacobian_(imu.acc_bias_jacobian()),
        delta_v_(imu.delta_v()),
        delta_p_(imu.delta_p()),
        gyr_bias_(imu.gyr_bias()),
        acc_bias_(imu.acc_bias()),
        g_n_(g_n),
        duration_s_(imu.duration_s()) {}

  void advance(Rot3T<S>& nRb, Vec3<S>& v, Vec3<S>& p) const {
    const S h = duration_s_;
    p += v * h + S(0.5) * h * h * g_n_ + nRb * delta_p_;
    v += h * g_n_ + nRb * delta_v_;
    nRb = (nRb * delta_R_).normalized();
  }

  template <class T>
  Vec<T, 9> bias_correction(const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias) const {
    return times<T, 3>(gyr_jacobian_, gyr_bias - gyr_bias_.template cast<T>()) +
           times<T, 3>(acc_jacobian_, acc_bias - acc_bias_.template cast<T>());
  }
  template <class T>
  Mat<T, 9, 3> through_gyr_bias(const Mat3<T>& outer) const {
    return through<T, 3>(outer, gyr_jacobian_);
  }
  template <class T>
  Mat<T, 9, 3> through_acc_bias(const Mat3<T>& outer) const {
    return through<T, 3>(outer, acc_jacobian_);
  }

  template <class T>
  Vec<T, 9> residual(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                     const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                     const Vec<T, 9>& d) const {
    Vec<T, 9> r;
    r.template head<3>() = rotation(R_i, R_j, d).Log();
    r.template segment<3>(3) = R_i.unrotate(velocity_change(v_i, v_j)) -
                               delta_v_.template cast<T>() - d.template segment<3>(3);
    r.template tail<3>() = R_i.unrotate(displacement(v_i, p_i, p_j)) - delta_p_.template cast<T>() -
                           d.template tail<3>();
    return r;
  }

  // outer: what d_R passes through on its way into r_R; d r / d d is -(outer, I, I).
  template <class T>
  Vec<T, 9> linearize(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                      const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                      const Vec<T, 9>& d, M93<T>& J_Ri, M93<T>& J_vi, M93<T>& J_pi, M93<T>& J_Rj,
                      M93<T>& J_vj, M93<T>& J_pj, Mat3<T>& outer) const {
    const T h(duration_s_);
    const Rot3T<T> Q = rotation(R_i, R_j, d);
    const Mat3<T> bRn = R_i.matrix().transpose();
    const Vec3<T> dv = velocity_change(v_i, v_j), dp = displacement(v_i, p_i, p_j);
    Vec<T, 9> r;
    r.template head<3>() = Q.Log();
    r.template segment<3>(3) = bRn * dv - delta_v_.template cast<T>() - d.template segment<3>(3);
    r.template tail<3>() = bRn * dp - delta_p_.template cast<T>() - d.template tail<3>();

    for (M93<T>* J : {&J_Ri, &J_vi, &J_pi, &J_Rj, &J_vj, &J_pj}) J->setZero();
    const Mat3<T> J_log = so3::right_jacobian_inverse(Vec3<T>(r.template head<3>()));
    J_Rj.template topRows<3>() = J_log * R_j.matrix().transpose();
    J_Ri.template topRows<3>() = -J_Rj.template topRows<3>();
    J_Ri.template middleRows<3>(3) = bRn * so3::hat(dv);
    J_Ri.template bottomRows<3>() = bRn * so3::hat(dp);
    J_vi.template middleRows<3>(3) = -bRn;
    J_vi.template bottomRows<3>() = -bRn * h;
    J_pi.template bottomRows<3>() = -bRn;
    J_vj.template middleRows<3>(3) = bRn;
    J_pj.template bottomRows<3>() = bRn;
    outer = J_log * Q.matrix().transpose() * so3::right_jacobian(Vec3<T>(d.template head<3>()));
    return r;
  }

  // d r / d x from J = d d / d x.
  template <class T, int N>
  static Mat<T, 9, N> through(const Mat3<T>& outer, const Mat<S, 9, N>& J) {
    Mat<T, 9, N> out = -J.template cast<T>();
    out.template topRows<3>() = outer * out.template topRows<3>();
    return out;
  }
  template <class T, int N>
  static Vec<T, 9> times(const Mat<S, 9, N>& J, const Vec<T, N>& x) {
    return J.template cast<T>().lazyProduct(x);  // lanes compare only as lanes
  }

 private:
  template <class T>
  Rot3T<T> rotation(const Rot3T<T>& R_i, const Rot3T<T>& R_j, const Vec<T, 9>& d) const {
    const Rot3T<T> delta =
        delta_R_.template cast<T>() * Rot3T<T>::Exp(Vec3<T>(d.template head<3>()));
    return delta.inverse() * (R_i.inverse() * R_j);
  }
  template <class T>
  Vec3<T> velocity_change(const Vec3<T>& v_i, const Vec3<T>& v_j) const {
    return v_j - v_i - g_n_.template cast<T>() * T(duration_s_);
  }
  template <class T>
  Vec3<T> displacement(const Vec3<T>& v_i, const Vec3<T>& p_i, const Vec3<T>& p_j) const {
    const T h(duration_s_);
    return p_j - p_i - v_i * h - g_n_.template cast<T>() * (T(0.5) * h * h);
  }

  // In an order that leaves no gaps in memory.
  Rot3T<S> delta_R_;
  Mat<S, 9, 3> gyr_jacobian_, acc_jacobian_;
  Vec3<S> delta_v_, delta_p_, gyr_bias_, acc_bias_, g_n_;
  S duration_s_;
};

}  // namespace detail

// Both biases unknown.
template <class S>
class PreintegratedImuText {
  template <class T>
  using M93 = Mat<T, 9, 3>;

 public:
  PreintegratedImuText(const PreintegratedImu& imu, const Vector3& g_n) : shared_(imu, g_n) {}

  // From the first node's attitude, velocity and position to the second's, as the samples say.
  void advance(Rot3T<S>& nRb, Vec3<S>& v, Vec3<S>& p) const { shared_.advance(nRb, v, p); }

  template <class T>
  Vec<T, 9> residual(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                     const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                     const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias) const {
    return shared_.residual(R_i, v_i, p_i, R_j, v_j, p_j,
                            shared_.bias_correction(gyr_bias, acc_bias));
  }

  template <class T>
  Vec<T, 9> linearize(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                      const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                      const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias, M93<T>& J_Ri, M93<T>& J_vi,
                      M93<T>& J_pi, M93<T>& J_Rj, M93<T>& J_vj, M93<T>& J_pj, M93<T>& J_gyr,
                      M93<T>& J_acc) const {
    Mat3<T> outer;
    Vec<T, 9> r =
        shared_.linearize(R_i, v_i, p_i, R_j, v_j, p_j, shared_.bias_correction(gyr_bias, acc_bias),
                          J_Ri, J_vi, J_pi, J_Rj, J_vj, J_pj, outer);
    J_gyr = shared_.through_gyr_bias(outer);
    J_acc = shared_.through_acc_bias(outer);
    return r;
  }

 private:
  detail::ImuText<S> shared_;
};

// Noise of the three residuals. loose_m: standard deviation, m, of a further error of the position
// in this interval. Where nothing else depends on the position, its value changes no other
// estimate. A value of 1 keeps the problem well conditioned: without it positions are known to a
// micrometre from node to node but hardly at all as a whole, which uses up the digits of double
// arithmetic.
inline Noise<9> imu_noise(const PreintegratedImu& imu, double gyr_density, double acc_density,
                          double loose_m) {
  PreintegratedImu::Matrix9 covariance = imu.covariance(gyr_density, acc_density);
  covariance.bottomRightCorner<3, 3>().diagonal().array() += loose_m * loose_m;
  return Noise<9>::full(covariance);
}

// Densities: of the two sensors' noise, rad/s and m/s^2 per sqrt(Hz). loose_m: imu_noise().
class PreintegratedImuFactor
    : public Factor<9, Rot3, Vector3, Vector3, Rot3, Vector3, Vector3, Vector3, Vector3>,
      public PreintegratedImuText<double> {
 public:
  template <class S>
  using Text = PreintegratedImuText<S>;

  PreintegratedImuFactor(Key R_i, Key v_i, Key p_i, Key R_j, Key v_j, Key p_j, Key gyr_bias,
                         Key acc_bias, const PreintegratedImu& imu, double gyr_density,
                         double acc_density, const Vector3& g_n, double loose_m = 0.0)
      : Factor({R_i, v_i, p_i, R_j, v_j, p_j, gyr_bias, acc_bias},
               imu_noise(imu, gyr_density, acc_density, loose_m)),
        PreintegratedImuText(imu, g_n) {}
};
template <>
inline constexpr bool kHasLanes<PreintegratedImuFactor> = true;

// The gyroscope's scale errors and misalignment unknown, too: gyr = (I + S) w + o_w.
template <class S>
class ScaledImuText {
  template <class T>
  using M93 = Mat<T, 9, 3>;

 public:
  ScaledImuText(const PreintegratedImu& imu, const Vector3& g_n)
      : shared_(imu, g_n), jacobian_(imu.gyr_matrix_jacobian()), matrix_(imu.gyr_matrix()) {}

  template <class T>
  Vec<T, 9> residual(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                     const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                     const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias,
                     const Vec<T, 9>& gyr_matrix) const {
    return shared_.residual(R_i, v_i, p_i, R_j, v_j, p_j,
                            correction(gyr_bias, acc_bias, gyr_matrix));
  }

  template <class T>
  Vec<T, 9> linearize(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                      const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                      const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias, const Vec<T, 9>& gyr_matrix,
                      M93<T>& J_Ri, M93<T>& J_vi, M93<T>& J_pi, M93<T>& J_Rj, M93<T>& J_vj,
                      M93<T>& J_pj, M93<T>& J_gyr, M93<T>& J_acc, Mat<T, 9, 9>& J_matrix) const {
    Mat3<T> outer;
    Vec<T, 9> r =
        shared_.linearize(R_i, v_i, p_i, R_j, v_j, p_j, correction(gyr_bias, acc_bias, gyr_matrix),
                          J_Ri, J_vi, J_pi, J_Rj, J_vj, J_pj, outer);
    J_gyr = shared_.through_gyr_bias(outer);
    J_acc = shared_.through_acc_bias(outer);
    J_matrix = shared_.template through<T, 9>(outer, jacobian_);
    return r;
  }

 private:
  template <class T>
  Vec<T, 9> correction(const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias,
                       const Vec<T, 9>& gyr_matrix) const {
    return shared_.bias_correction(gyr_bias, acc_bias) +
           shared_.template times<T, 9>(jacobian_, gyr_matrix - matrix_.template cast<T>());
  }

  detail::ImuText<S> shared_;
  Mat<S, 9, 9> jacobian_;
  Vec<S, 9> matrix_;
};

class ScaledImuFactor : public Factor<9, Rot3, Vector3, Vector3, Rot3, Vector3, Vector3, Vector3,
                                      Vector3, GyroMatrix>,
                        public ScaledImuText<double> {
 public:
  template <class S>
  using Text = ScaledImuText<S>;

  // imu: integrated with S.
  ScaledImuFactor(Key R_i, Key v_i, Key p_i, Key R_j, Key v_j, Key p_j, Key gyr_bias, Key acc_bias,
                  Key gyr_matrix, const PreintegratedImu& imu, double gyr_density,
                  double acc_density, const Vector3& g_n, double loose_m = 0.0)
      : Factor({R_i, v_i, p_i, R_j, v_j, p_j, gyr_bias, acc_bias, gyr_matrix},
               imu_noise(imu, gyr_density, acc_density, loose_m)),
        ScaledImuText(imu, g_n) {}
};
template <>
inline constexpr bool kHasLanes<ScaledImuFactor> = true;

}  // namespace magimu
