// SPDX-License-Identifier: BSD-3-Clause
// The sound form: error state (e, o_a, o_w, D and o_m of each magnetometer, dips), R <- R Exp(e).
// A filter that linearizes at its running estimate takes in its first samples where the parameters
// wander by as much as their wide prior allows, and stays wrong and sure. Here a pass linearizes
// everything about the parameters that the last pass ended with, and about the orientations that
// the gyroscope, accelerometer and magnetometer give with them; the state is the departure from
// there.
#include "calibration/rivals/wu_filter.h"

#include <Eigen/Dense>
#include <chrono>
#include <cmath>

#include "calibration/motion/nodes.h"
#include "calibration/rivals/wu_update.h"
#include "calibration/start/attitude.h"
#include "graph/so3.h"

namespace magimu {
namespace {

// Standard deviations at the start, far beyond what any guess is wrong by: they decide nothing.
constexpr double kWuAcc = 1.0, kWuGyr = 0.1;       // m/s^2, rad/s
constexpr double kWuField = 1.0;                   // of the strength: D and o_m
constexpr double kWuDip = 0.5, kWuAttitude = 0.3;  // rad
constexpr double kWuSettled = 1e-2;                // standard deviations between passes

class SoundWu {
 public:
  SoundWu(const std::vector<const Recording*>& recordings, const WuOptions& options)
      : recordings_(recordings), options_(options), field_(fields_of(recordings)) {
    for (const Recording* r : recordings) steps_.push_back(filter_steps(*r));
  }

  // From the parameters of `at` to those after all samples.
  void pass(WuEstimate& at) const {
    const auto mags = Eigen::Index(at.theta.mag.size()), fields = Eigen::Index(at.dip_rad.size());
    dip_column_ = 9 + 12 * mags;
    VectorXd sigma(dip_column_ + fields);
    sigma.head<9>() << Vector3::Constant(kWuAttitude), Vector3::Constant(kWuAcc),
        Vector3::Constant(kWuGyr);
    for (Eigen::Index m = 0; m < mags; ++m) {
      const double strength = at.theta.mag[std::size_t(m)].distortion.norm() / std::sqrt(3.0);
      sigma.segment<12>(9 + 12 * m).setConstant(kWuField * strength);
    }
    sigma.tail(fields).setConstant(kWuDip);
    ErrorStateUpdate filter(MatrixXd(sigma.cwiseAbs2().asDiagonal()));
    at.squares = 0.0;
    at.rows = 0;
    at.nRb.clear();
    for (std::size_t r = 0; r < recordings_.size(); ++r) {
      filter.P.topRows<3>().setZero();
      filter.P.leftCols<3>().setZero();
      filter.P.diagonal().head<3>().setConstant(kWuAttitude * kWuAttitude);
      filter.delta.head<3>().setZero();
      SensorParameters theta = at.theta;
      theta.dip_rad = at.dip_rad[std::size_t(field_[r])];
      at.nRb.push_back(orientations(r, theta));
      run(r, at, theta, at.nRb.back(), filter);
    }
    move(at.theta, at.dip_rad, filter.delta);
    const Eigen::Index n = filter.P.rows() - 3;
    at.covariance = filter.P.bottomRightCorner(n, n);
    ++at.passes;
  }

 private:
  // theta, dip and R are where everything is linearized; filter.delta is the state's departure.
  void run(std::size_t r, WuEstimate& at, const SensorParameters& theta,
           const std::vector<Rot3>& nRb, ErrorStateUpdate& filter) const {
    const Recording& recording = *recordings_[r];
    const double dip = theta.dip_rad;
    const Eigen::Index dip_column = dip_column_ + field_[r];
    const double acc_variance = options_.noise.acc * options_.noise.acc * recording.acc.rate_hz();
    std::vector<double> mag_variance;
    for (const VectorSeries& mag : recording.mag) {
      mag_variance.push_back(options_.noise.mag * options_.noise.mag * mag.rate_hz());
    }
    const Vector3 up = -gravity_n(options_.gravity);
    for (std::size_t k = 0; k < steps_[r].size(); ++k) {
      const FilterStep& step = steps_[r][k];
      const Matrix3 bRn = nRb[k].matrix().transpose();
      if (step.has_acc) {
        const Vector3 f = bRn * up, v = step.acc - f - theta.acc_bias;
        const Matrix3 H = so3::hat<double>(f);
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) filter.set(j, H(i, j));
          filter.set(3 + i, 1.0);
          at.squares += filter.take(v[i], acc_variance);
        }
        at.rows += 3;
      }
      const Vector3 b = bRn * unit_field(dip);
      const Vector3 db = bRn * Vector3(0.0, -std::sin(dip), -std::cos(dip));
      for (const FilterStep::Mag& sample : step.mag) {
        const MagnetometerParameters& mag = theta.mag[std::size_t(sample.sensor)];
        const Vector3 v = sample.value - mag.distortion * b - mag.bias;
        const Matrix3 H = mag.distortion * so3::hat<double>(b);
        const Eigen::Index first = 9 + 12 * sample.sensor;
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) {
            filter.set(j, H(i, j));
            filter.set(first + 3 * j + i, b[j]);
          }
          filter.set(first + 9 + i, 1.0);
          filter.set(dip_column, mag.distortion.row(i).dot(db));
          at.squares += filter.take(v[i], mag_variance[std::size_t(sample.sensor)]);
        }
        at.rows += 3;
      }
      if (step.dt > 0.0) predict(step, theta, nRb[k], nRb[k + 1], filter);
    }
  }

  // R Exp(e) Exp(phi - dt o_w) = R1 Exp(e1): e1 = Log(R1' R Exp(phi)) + Exp(-phi) e - J_r(phi) dt
  // o_w.
  void predict(const FilterStep& step, const SensorParameters& theta, const Rot3& R, const Rot3& R1,
               ErrorStateUpdate& filter) const {
    MatrixXd& P = filter.P;
    const Vector3 phi = (step.rate - theta.gyr_bias) * step.dt;
    const Rot3 turn = Rot3::Exp(phi);
    const Matrix3 E = turn.matrix().transpose();
    const Matrix3 G = -step.dt * so3::right_jacobian<double>(phi);
    const Eigen::Matrix<double, 3, Eigen::Dynamic> rows =
        E * P.topRows<3>() + G * P.middleRows<3>(6);
    P.topRows<3>() = rows;
    const Eigen::Matrix<double, Eigen::Dynamic, 3> columns =
        P.leftCols<3>() * E.transpose() + P.middleCols<3>(6) * G.transpose();
    P.leftCols<3>() = columns;
    P.diagonal().head<3>().array() += step.dt * options_.noise.gyr * options_.noise.gyr;
    const Vector3 e = filter.delta.head<3>(), o_w = filter.delta.segment<3>(6);
    filter.delta.head<3>() = (R1.inverse() * (R * turn)).Log() + E * e + G * o_w;
  }

  static void move(SensorParameters& theta, std::vector<double>& dips, const VectorXd& delta) {
    theta.acc_bias += delta.segment<3>(3);
    theta.gyr_bias += delta.segment<3>(6);
    Eigen::Index at = 9;
    for (MagnetometerParameters& mag : theta.mag) {
      mag.distortion += delta.segment<9>(at).reshaped(3, 3);
      mag.bias += delta.segment<3>(at + 9);
      at += 12;
    }
    for (double& dip : dips) dip += delta[at++];
    theta.dip_rad = dips.front();
  }

  // The orientations that the samples give with these parameters.
  std::vector<Rot3> orientations(std::size_t r, const SensorParameters& theta) const {
    const Recording& recording = *recordings_[r];
    const IntegratedRotation gyr(recording.gyr, theta.gyr_bias);
    const Rot3 start = estimate_attitudes(recording, theta, gyr, {steps_[r].front().t}).front();
    const KokModel model = kok_model(recording, options_.noise, options_.gravity, kWuAttitude);
    return KokFilter(steps_[r], model).orientations(theta, start);
  }

  const std::vector<const Recording*>& recordings_;
  WuOptions options_;
  std::vector<int> field_;
  std::vector<std::vector<FilterStep>> steps_;
  mutable Eigen::Index dip_column_ = 0;
};

VectorXd wu_vector(const WuEstimate& e) {
  std::vector<double> v;
  const auto add = [&](const auto& x) { v.insert(v.end(), x.data(), x.data() + x.size()); };
  add(e.theta.acc_bias);
  add(e.theta.gyr_bias);
  for (const MagnetometerParameters& mag : e.theta.mag) {
    add(mag.distortion);
    add(mag.bias);
  }
  v.insert(v.end(), e.dip_rad.begin(), e.dip_rad.end());
  return Eigen::Map<const VectorXd>(v.data(), Eigen::Index(v.size()));
}

}  // namespace

WuEstimate wu_filter(const std::vector<const Recording*>& recordings, const SensorParameters& guess,
                     const std::vector<double>& dip_rad, const WuOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const SoundWu filter(recordings, options);
  WuEstimate at;
  at.theta = guess;
  at.dip_rad = dip_rad;
  VectorXd before = wu_vector(at);
  do {
    filter.pass(at);
    const VectorXd now = wu_vector(at);
    const VectorXd sigma = at.covariance.diagonal().cwiseMax(1e-300).cwiseSqrt();
    at.last_change = (now - before).cwiseQuotient(sigma).cwiseAbs().maxCoeff();
    before = now;
  } while (at.passes < options.max_passes && !(at.last_change < kWuSettled));
  at.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return at;
}

}  // namespace magimu
