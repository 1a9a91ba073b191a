// SPDX-License-Identifier: BSD-3-Clause
// The published form: states (attitude, o_w, o_a, S and h of each magnetometer, m0, g0);
// mag = S R'm0 + h, acc = -R'g0 + o_a, with R relative to the first body frame, R <- Exp(d) R.
#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "calibration/rivals/wu_filter.h"
#include "calibration/rivals/wu_update.h"
#include "graph/so3.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

// Standard deviations at the start, as in the published simulation study.
constexpr double kStartGyr = 1e-3, kStartAcc = 0.5, kStartS = 0.1, kStartH = 2.0, kStartM = 4.0,
                 kStartG = 1.0;
// Process noise of a step is dt times the square of these: on biases, m0 and g0.
constexpr double kWalkGyr = 1e-5, kWalkAcc = 1e-5, kWalkM = 0.05, kWalkG = 7e-8;

}  // namespace

WuEstimate wu_published(const Recording& recording, const Vector3& gyr_bias,
                        const WuOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<FilterStep> steps = filter_steps(recording);
  const auto mags = Eigen::Index(recording.mag.size());
  const Eigen::Index M = 9 + 12 * mags, G = M + 3, n = G + 3;
  WuEstimate out;
  out.theta.gyr_bias = gyr_bias;
  out.theta.mag.assign(std::size_t(mags), {Matrix3::Identity(), Vector3::Zero()});
  Vector3 m0 = recording.mag.front().v.front(), g0 = -recording.acc.v.front();
  Rot3 R;
  VectorXd sigma = VectorXd::Zero(n), walk = VectorXd::Zero(n);
  sigma.segment<3>(3).setConstant(kStartGyr);
  sigma.segment<3>(6).setConstant(kStartAcc);
  for (Eigen::Index m = 0; m < mags; ++m) {
    sigma.segment<9>(9 + 12 * m).setConstant(kStartS);
    sigma.segment<3>(18 + 12 * m).setConstant(kStartH);
  }
  sigma.segment<3>(M).setConstant(kStartM);
  sigma.segment<3>(G).setConstant(kStartG);
  walk.head<3>().setConstant(options.noise.gyr);
  walk.segment<3>(3).setConstant(kWalkGyr);
  walk.segment<3>(6).setConstant(kWalkAcc);
  walk.segment<3>(M).setConstant(kWalkM);
  walk.segment<3>(G).setConstant(kWalkG);
  ErrorStateUpdate filter(MatrixXd(sigma.cwiseAbs2().asDiagonal()));
  const double acc_variance = options.noise.acc * options.noise.acc * recording.acc.rate_hz();
  std::vector<double> mag_variance;
  for (const VectorSeries& mag : recording.mag) {
    mag_variance.push_back(options.noise.mag * options.noise.mag * mag.rate_hz());
  }
  std::vector<Rot3>& relative = out.nRb.emplace_back();
  for (const FilterStep& step : steps) {
    const Matrix3 bR = R.matrix().transpose();
    if (step.has_acc) {
      const Vector3 v = step.acc + bR * g0 - out.theta.acc_bias;
      const Matrix3 H = -bR * so3::hat<double>(g0);  // -R'(I - [d]x) g0
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          filter.set(j, H(i, j));
          filter.set(G + j, -bR(i, j));
        }
        filter.set(6 + i, 1.0);
        out.squares += filter.take(v[i], acc_variance);
      }
      out.rows += 3;
    }
    for (const FilterStep::Mag& sample : step.mag) {
      const MagnetometerParameters& mag = out.theta.mag[std::size_t(sample.sensor)];
      const Vector3 b = bR * m0, v = sample.value - mag.distortion * b - mag.bias;
      const Matrix3 SR = mag.distortion * bR, H = SR * so3::hat<double>(m0);
      const Eigen::Index first = 9 + 12 * sample.sensor;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          filter.set(j, H(i, j));
          filter.set(first + 3 * j + i, b[j]);
          filter.set(M + j, SR(i, j));
        }
        filter.set(first + 9 + i, 1.0);
        out.squares += filter.take(v[i], mag_variance[std::size_t(sample.sensor)]);
      }
      out.rows += 3;
    }
    const VectorXd& d = filter.delta;
    R = Rot3::Exp(d.head<3>()) * R;
    out.theta.gyr_bias += d.segment<3>(3);
    out.theta.acc_bias += d.segment<3>(6);
    for (Eigen::Index m = 0; m < mags; ++m) {
      out.theta.mag[std::size_t(m)].distortion += d.segment<9>(9 + 12 * m).reshaped(3, 3);
      out.theta.mag[std::size_t(m)].bias += d.segment<3>(18 + 12 * m);
    }
    m0 += d.segment<3>(M);
    g0 += d.segment<3>(G);
    filter.delta.setZero();
    relative.push_back(R);
    if (step.dt <= 0.0) continue;
    // d <- d - R dt o_w
    const Matrix3 F = -step.dt * R.matrix();
    const Eigen::Matrix<double, 3, Eigen::Dynamic> rows =
        filter.P.topRows<3>() + F * filter.P.middleRows<3>(3);
    filter.P.topRows<3>() = rows;
    const Eigen::Matrix<double, Eigen::Dynamic, 3> columns =
        filter.P.leftCols<3>() + filter.P.middleCols<3>(3) * F.transpose();
    filter.P.leftCols<3>() = columns;
    filter.P.diagonal() += step.dt * walk.cwiseAbs2();
    R = (R * Rot3::Exp((step.rate - out.theta.gyr_bias) * step.dt)).normalized();
  }
  // D = S |m0|; sin(dip) is the cosine between field and gravity.
  const double strength = m0.norm();
  const Vector3 m = m0 / strength, g = g0.normalized();
  const double sine = std::clamp(m.dot(g), -1.0, 1.0);
  out.dip_rad = {std::asin(sine)};
  out.theta.dip_rad = out.dip_rad.front();
  MatrixXd J = MatrixXd::Zero(7 + 12 * mags, n);
  J.block<3, 3>(0, 6).setIdentity();
  J.block<3, 3>(3, 3).setIdentity();
  for (Eigen::Index k = 0; k < mags; ++k) {
    Matrix3& S = out.theta.mag[std::size_t(k)].distortion;
    J.block<9, 9>(6 + 12 * k, 9 + 12 * k) = strength * Eigen::Matrix<double, 9, 9>::Identity();
    J.block<9, 3>(6 + 12 * k, M) = S.reshaped() * m.transpose();
    J.block<3, 3>(15 + 12 * k, 18 + 12 * k).setIdentity();
    S *= strength;
  }
  const double cosine = std::sqrt(std::max(1e-12, 1.0 - sine * sine));
  J.block<1, 3>(6 + 12 * mags, M) = (g - sine * m).transpose() / (strength * cosine);
  J.block<1, 3>(6 + 12 * mags, G) = (m - sine * g).transpose() / (g0.norm() * cosine);
  out.covariance = J * filter.P * J.transpose();
  // From the first body frame to n: up is -g, and the field has no part to the east.
  Matrix3 nR;
  const Vector3 east = m.cross(-g).normalized();
  nR << east.transpose(), (-g).cross(east).transpose(), -g.transpose();
  for (Rot3& Rk : relative) Rk = Rot3::from_matrix(nR) * Rk;
  out.passes = 1;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace magimu
