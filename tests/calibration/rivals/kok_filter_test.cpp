// SPDX-License-Identifier: BSD-3-Clause
// The sensitivities of Kok's filter against numerical derivatives.
#include "calibration/rivals/kok_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "calibration/rivals/kok_scoring.h"
#include "graph/so3.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

Simulation kok_simulation(double seconds) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 20.0;
  options.duration_s = seconds;
  return simulate(options);
}

KokModel kok_model(const Simulation& s, double start_sigma) {
  const double root = std::sqrt(20.0);
  return {s.truth.noise.acc * root,
          {s.truth.noise.mag * root},
          s.truth.noise.gyr,
          s.truth.gravity,
          start_sigma};
}

// Parameters and start moved by d, in the order of kok_columns().
void move_kok(SensorParameters& theta, Rot3& start, const VectorXd& d) {
  theta.acc_bias += d.head<3>();
  theta.gyr_bias += d.segment<3>(3);
  theta.mag[0].distortion += d.segment<9>(6).reshaped(3, 3);
  theta.mag[0].bias += d.segment<3>(15);
  theta.dip_rad += d[18];
  start = start * Rot3::Exp(d.tail<3>());
}

// Whitened innovations with gains and S given, by the joint form of the update:
// w = L^-1 e, R <- R Exp(K e), rebuilt here from the rows.
VectorXd replay_kok(const std::vector<FilterStep>& steps, const std::vector<KokFilter::Row>& rows,
                    const std::vector<Vector3>& H, const SensorParameters& theta, Rot3 R,
                    double g0) {
  VectorXd w(Eigen::Index(rows.size()));
  std::size_t k = 0;
  for (const FilterStep& step : steps) {
    Vector3 e[2];
    int sensors = 0;
    if (step.has_acc) {
      e[sensors++] = step.acc - accelerometer_model(R, theta.acc_bias, gravity_n(g0));
    }
    if (!step.mag.empty()) {
      e[sensors++] = step.mag[0].value - magnetometer_model(R, theta.mag[0].distortion,
                                                            theta.mag[0].bias, theta.dip_rad);
    }
    Vector3 delta = Vector3::Zero();
    for (int i = 0; i < 3 * sensors; ++i, ++k) {
      const double v = e[i / 3][i % 3] - H[k].dot(delta);
      w[Eigen::Index(k)] = v / std::sqrt(rows[k].S);
      delta += rows[k].gain * v;
    }
    R = R * Rot3::Exp(delta) * Rot3::Exp((step.rate - theta.gyr_bias) * step.dt);
  }
  return w;
}

// The measurement rows that the filter has at theta: with its gains, what replay_kok() holds fixed.
std::vector<Vector3> kok_measurement_rows(const std::vector<FilterStep>& steps,
                                          const std::vector<KokFilter::Row>& rows,
                                          const SensorParameters& theta, Rot3 R, double g0) {
  std::vector<Vector3> H;
  for (const FilterStep& step : steps) {
    Matrix3 parts[2];
    Vector3 e[2];
    int sensors = 0;
    if (step.has_acc) {
      e[sensors] = step.acc - accelerometer_model(R, theta.acc_bias, gravity_n(g0));
      parts[sensors++] = so3::hat<double>(R.unrotate(Vector3(-gravity_n(g0))));
    }
    if (!step.mag.empty()) {
      const MagnetometerParameters& mag = theta.mag[0];
      e[sensors] =
          step.mag[0].value - magnetometer_model(R, mag.distortion, mag.bias, theta.dip_rad);
      parts[sensors++] = mag.distortion * so3::hat<double>(R.unrotate(unit_field(theta.dip_rad)));
    }
    Vector3 delta = Vector3::Zero();
    for (int i = 0; i < 3 * sensors; ++i) {
      const std::size_t k = H.size();
      H.push_back(parts[i / 3].row(i % 3).transpose());
      delta += rows[k].gain * (e[i / 3][i % 3] - H[k].dot(delta));
    }
    R = R * Rot3::Exp(delta) * Rot3::Exp((step.rate - theta.gyr_bias) * step.dt);
  }
  return H;
}

TEST(KokFilter, sensitivities_are_the_numerical_derivatives_at_the_gains_it_has) {
  const Simulation s = kok_simulation(15.0);
  const std::vector<FilterStep> steps = filter_steps(s.recording);
  SensorParameters theta = s.truth.parameters;
  Rot3 start = s.truth.nRb.front();
  VectorXd away = 1e-3 * VectorXd::LinSpaced(22, -1.0, 1.0);
  move_kok(theta, start, away);
  for (const double start_sigma : {0.0, 0.1}) {
    const KokFilter filter(steps, kok_model(s, start_sigma));
    const std::vector<KokFilter::Row> rows = filter.rows(theta, start);
    ASSERT_EQ(rows.size(), 6 * steps.size());
    const std::vector<Vector3> H = kok_measurement_rows(steps, rows, theta, start, s.truth.gravity);
    const VectorXd w = replay_kok(steps, rows, H, theta, start, s.truth.gravity);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      ASSERT_NEAR(w[Eigen::Index(k)], rows[k].w, 1e-8) << "row " << k;
    }
    for (Eigen::Index c = 0; c < 22; ++c) {
      const double h = 1e-6;
      VectorXd moved[2];
      for (int side = 0; side < 2; ++side) {
        SensorParameters there = theta;
        Rot3 first = start;
        move_kok(there, first, (side == 0 ? -h : h) * VectorXd::Unit(22, c));
        moved[side] = replay_kok(steps, rows, H, there, first, s.truth.gravity);
      }
      const VectorXd numerical = (moved[1] - moved[0]) / (2.0 * h);
      const double scale = std::max(1.0, numerical.cwiseAbs().maxCoeff());
      for (std::size_t k = 0; k < rows.size(); ++k) {
        ASSERT_NEAR(rows[k].sensitivity[c], numerical[Eigen::Index(k)], 1e-6 * scale)
            << "row " << k << ", column " << c;
      }
    }
  }
}

// What the sensitivities leave out, the gains' own dependence, hardly moves the optimum: the exact
// gradient of the likelihood there, in standard deviations.
TEST(KokScoring, ends_where_the_exact_gradient_of_the_likelihood_vanishes) {
  const Simulation s = kok_simulation(60.0);
  const KokProblem problem({&s.recording}, {.noise = s.truth.noise, .gravity = s.truth.gravity});
  const KokPoint truth{s.truth.parameters, {s.truth.parameters.dip_rad}, {s.truth.nRb.front()}};
  const KokEstimate e = kok_scoring(problem, truth);
  ASSERT_TRUE(e.fit.converged()) << e.fit.message;
  EXPECT_LE(e.fit.iterations, 8);
  KokNormal normal;
  problem.linearize(e.point, normal);
  const MatrixXd C = normal.information.inverse();
  VectorXd gradient(problem.unknowns());
  for (Eigen::Index c = 0; c < gradient.size(); ++c) {
    const double h = 1e-2 * std::sqrt(C(c, c));
    const VectorXd d = h * VectorXd::Unit(gradient.size(), c);
    gradient[c] = (kok_objective(problem.run(problem.moved(e.point, d))) -
                   kok_objective(problem.run(problem.moved(e.point, -d)))) /
                  (2.0 * h);
  }
  EXPECT_LT(std::sqrt(gradient.dot(C * gradient)), 0.1);
}

}  // namespace
}  // namespace magimu
