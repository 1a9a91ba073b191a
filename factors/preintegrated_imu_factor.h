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
class ImuResidual {
  template <class T>
  using M93 = Mat<T, 9, 3>;

 public:
  ImuResidual(const PreintegratedImu& imu, const Vector3& g_n) : imu_(imu), g_n_(g_n) {}

  const PreintegratedImu& imu() const { return imu_; }

  template <class T>
  Vec<T, 9> bias_correction(const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias) const {
    return imu_.gyr_bias_jacobian().cast<T>() * (gyr_bias - imu_.gyr_bias().cast<T>()) +
           imu_.acc_bias_jacobian().cast<T>() * (acc_bias - imu_.acc_bias().cast<T>());
  }

  template <class T>
  Vec<T, 9> residual(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                     const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                     const Vec<T, 9>& d) const {
    Vec<T, 9> r;
    r.template head<3>() = rotation(R_i, R_j, d).Log();
    r.template segment<3>(3) = R_i.unrotate(velocity_change(v_i, v_j)) - imu_.delta_v().cast<T>() -
                               d.template segment<3>(3);
    r.template tail<3>() =
        R_i.unrotate(displacement(v_i, p_i, p_j)) - imu_.delta_p().cast<T>() - d.template tail<3>();
    return r;
  }

  // outer: what d_R passes through on its way into r_R; d r / d d is -(outer, I, I).
  template <class T>
  Vec<T, 9> linearize(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                      const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                      const Vec<T, 9>& d, M93<T>& J_Ri, M93<T>& J_vi, M93<T>& J_pi, M93<T>& J_Rj,
                      M93<T>& J_vj, M93<T>& J_pj, Mat3<T>& outer) const {
    const T h(imu_.duration_s());
    const Rot3T<T> Q = rotation(R_i, R_j, d);
    const Mat3<T> bRn = R_i.matrix().transpose();
    const Vec3<T> dv = velocity_change(v_i, v_j), dp = displacement(v_i, p_i, p_j);
    Vec<T, 9> r;
    r.template head<3>() = Q.Log();
    r.template segment<3>(3) = bRn * dv - imu_.delta_v().cast<T>() - d.template segment<3>(3);
    r.template tail<3>() = bRn * dp - imu_.delta_p().cast<T>() - d.template tail<3>();

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

  // d r / d x from d d / d x.
  template <class T, int N>
  static Mat<T, 9, N> through(const Mat3<T>& outer, const Mat<double, 9, N>& J_d) {
    Mat<T, 9, N> J = -J_d.template cast<T>();
    J.template topRows<3>() = outer * J.template topRows<3>();
    return J;
  }

 private:
  template <class T>
  Rot3T<T> rotation(const Rot3T<T>& R_i, const Rot3T<T>& R_j, const Vec<T, 9>& d) const {
    const Rot3T<T> delta = imu_.delta_R().cast<T>() * Rot3T<T>::Exp(Vec3<T>(d.template head<3>()));
    return delta.inverse() * (R_i.inverse() * R_j);
  }
  template <class T>
  Vec3<T> velocity_change(const Vec3<T>& v_i, const Vec3<T>& v_j) const {
    return v_j - v_i - (g_n_ * imu_.duration_s()).cast<T>();
  }
  template <class T>
  Vec3<T> displacement(const Vec3<T>& v_i, const Vec3<T>& p_i, const Vec3<T>& p_j) const {
    const double h = imu_.duration_s();
    return p_j - p_i - v_i * T(h) - (g_n_ * (0.5 * h * h)).cast<T>();
  }

  PreintegratedImu imu_;
  Vector3 g_n_;
};

}  // namespace detail

// Both biases unknown.
class PreintegratedImuFactor
    : public Factor<9, Rot3, Vector3, Vector3, Rot3, Vector3, Vector3, Vector3, Vector3> {
  template <class T>
  using M93 = Mat<T, 9, 3>;

 public:
  PreintegratedImuFactor(Key R_i, Key v_i, Key p_i, Key R_j, Key v_j, Key p_j, Key gyr_bias,
                         Key acc_bias, const PreintegratedImu& imu, const Vector3& g_n)
      : Factor({R_i, v_i, p_i, R_j, v_j, p_j, gyr_bias, acc_bias},
               Noise<9>::full(imu.covariance())),
        shared_(imu, g_n) {}

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
    J_gyr = shared_.through(outer, shared_.imu().gyr_bias_jacobian());
    J_acc = shared_.through(outer, shared_.imu().acc_bias_jacobian());
    return r;
  }

  // What was integrated.
  const PreintegratedImu& imu() const { return shared_.imu(); }

 private:
  detail::ImuResidual shared_;
};

// The gyroscope's scale errors and misalignment unknown, too: gyr = (I + S) w + o_w.
class ScaledImuFactor : public Factor<9, Rot3, Vector3, Vector3, Rot3, Vector3, Vector3, Vector3,
                                      Vector3, LowerTriangle> {
  template <class T>
  using M93 = Mat<T, 9, 3>;

 public:
  // imu: integrated with S.
  ScaledImuFactor(Key R_i, Key v_i, Key p_i, Key R_j, Key v_j, Key p_j, Key gyr_bias, Key acc_bias,
                  Key gyr_matrix, const PreintegratedImu& imu, const Vector3& g_n)
      : Factor({R_i, v_i, p_i, R_j, v_j, p_j, gyr_bias, acc_bias, gyr_matrix},
               Noise<9>::full(imu.covariance())),
        shared_(imu, g_n) {}

  template <class T>
  Vec<T, 9> residual(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                     const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                     const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias,
                     const Vec<T, 6>& gyr_matrix) const {
    return shared_.residual(R_i, v_i, p_i, R_j, v_j, p_j,
                            correction(gyr_bias, acc_bias, gyr_matrix));
  }

  template <class T>
  Vec<T, 9> linearize(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                      const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                      const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias, const Vec<T, 6>& gyr_matrix,
                      M93<T>& J_Ri, M93<T>& J_vi, M93<T>& J_pi, M93<T>& J_Rj, M93<T>& J_vj,
                      M93<T>& J_pj, M93<T>& J_gyr, M93<T>& J_acc, Mat<T, 9, 6>& J_matrix) const {
    Mat3<T> outer;
    Vec<T, 9> r =
        shared_.linearize(R_i, v_i, p_i, R_j, v_j, p_j, correction(gyr_bias, acc_bias, gyr_matrix),
                          J_Ri, J_vi, J_pi, J_Rj, J_vj, J_pj, outer);
    J_gyr = shared_.through(outer, shared_.imu().gyr_bias_jacobian());
    J_acc = shared_.through(outer, shared_.imu().acc_bias_jacobian());
    J_matrix = shared_.through(outer, shared_.imu().gyr_matrix_jacobian());
    return r;
  }

 private:
  template <class T>
  Vec<T, 9> correction(const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias,
                       const Vec<T, 6>& gyr_matrix) const {
    const Vec<T, 6> moved = gyr_matrix - shared_.imu().gyr_matrix().cast<T>();
    return shared_.bias_correction(gyr_bias, acc_bias) +
           shared_.imu().gyr_matrix_jacobian().cast<T>() * moved;
  }

  detail::ImuResidual shared_;
};

}  // namespace magimu
