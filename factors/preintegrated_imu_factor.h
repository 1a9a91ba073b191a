// SPDX-License-Identifier: BSD-3-Clause
// A hand moves the sensor: accelerometer and gyroscope between two nodes (R, v, p),
//
//   r_R = Log((delta_R Exp(J_R dw))' R_i' R_j)
//   r_v = R_i' (v_j - v_i - g h)                   - (delta_v + J_v (dw, da))
//   r_p = R_i' (p_j - p_i - v_i h - g h^2 / 2)     - (delta_p + J_p (dw, da))
//
// with dw, da the biases' distance from where the samples were integrated (PreintegratedImu;
// Forster et al. 2016, eq. 44-45) and g gravity in n. First order in dw, da: integrate again where
// they are large.
#pragma once

#include "factors/preintegrated_imu.h"
#include "graph/factor.h"

namespace magimu {

class PreintegratedImuFactor
    : public Factor<9, Rot3, Vector3, Vector3, Rot3, Vector3, Vector3, Vector3, Vector3> {
  template <class T>
  using M93 = Mat<T, 9, 3>;

 public:
  PreintegratedImuFactor(Key R_i, Key v_i, Key p_i, Key R_j, Key v_j, Key p_j, Key gyr_bias,
                         Key acc_bias, const PreintegratedImu& imu, const Vector3& g_n)
      : Factor({R_i, v_i, p_i, R_j, v_j, p_j, gyr_bias, acc_bias},
               Noise<9>::full(imu.covariance())),
        imu_(imu),
        g_n_(g_n) {}

  template <class T>
  Vec<T, 9> residual(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                     const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                     const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias) const {
    const Vec<T, 9> d = correction(gyr_bias, acc_bias);
    Vec<T, 9> r;
    r.template head<3>() = rotation(R_i, R_j, d).Log();
    r.template segment<3>(3) = R_i.unrotate(velocity_change(v_i, v_j)) - imu_.delta_v().cast<T>() -
                               d.template segment<3>(3);
    r.template tail<3>() =
        R_i.unrotate(displacement(v_i, p_i, p_j)) - imu_.delta_p().cast<T>() - d.template tail<3>();
    return r;
  }

  template <class T>
  Vec<T, 9> linearize(const Rot3T<T>& R_i, const Vec3<T>& v_i, const Vec3<T>& p_i,
                      const Rot3T<T>& R_j, const Vec3<T>& v_j, const Vec3<T>& p_j,
                      const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias, M93<T>& J_Ri, M93<T>& J_vi,
                      M93<T>& J_pi, M93<T>& J_Rj, M93<T>& J_vj, M93<T>& J_pj, M93<T>& J_gyr,
                      M93<T>& J_acc) const {
    const T h(imu_.duration_s());
    const Vec<T, 9> d = correction(gyr_bias, acc_bias);
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
    J_gyr = -imu_.gyr_bias_jacobian().cast<T>();
    J_acc = -imu_.acc_bias_jacobian().cast<T>();
    // The rotation's part passes through Exp and Log.
    const Mat3<T> outer =
        J_log * Q.matrix().transpose() * so3::right_jacobian(Vec3<T>(d.template head<3>()));
    J_gyr.template topRows<3>() = outer * J_gyr.template topRows<3>();
    J_acc.template topRows<3>() = outer * J_acc.template topRows<3>();
    return r;
  }

 private:
  template <class T>
  Vec<T, 9> correction(const Vec3<T>& gyr_bias, const Vec3<T>& acc_bias) const {
    return imu_.gyr_bias_jacobian().cast<T>() * (gyr_bias - imu_.gyr_bias().cast<T>()) +
           imu_.acc_bias_jacobian().cast<T>() * (acc_bias - imu_.acc_bias().cast<T>());
  }
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

}  // namespace magimu
