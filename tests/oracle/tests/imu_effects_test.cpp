// SPDX-License-Identifier: BSD-3-Clause
// What the catalogue's effects add to accelerometer and gyroscope, against docs/effects.md.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/oracle/tests/comparison.h"

namespace magimu::oracle {
namespace {

TEST(Effects, acc_scale_misalignment) {
  const Comparison c(make_effect("acc_scale_misalignment", {.01, .02, .03, -.04, .05, -.06}));
  Matrix3d L;
  L << .01, 0, 0, .02, .03, 0, -.04, .05, -.06;
  c.only_acc([&](double t) -> Vector3d { return L * c.f(t); });
}

TEST(Effects, gyro_scale_misalignment) {
  const Comparison c(make_effect("gyro_scale_misalignment", {1, 2, 3, 4, 5, 6, 7, 8, 9}));
  Matrix3d S;
  S << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  c.only_gyr([&](double t) -> Vector3d { return S * c.motion.omega(t); }, 2e-4);
}

TEST(Effects, gyro_g_sensitivity_is_the_mean_of_the_force_over_the_gyroscopes_interval) {
  const Comparison c(make_effect("gyro_g_sensitivity", {1, 2, 3, 4, 5, 6, 7, 8, 9}));
  Matrix3d G;
  G << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  c.only_gyr([&](double t) -> Vector3d { return G * c.f(t); }, 2e-2);
}

TEST(Effects, gyro_nonlinearity) {
  const Comparison c(make_effect("gyro_nonlinearity", {0.1, -0.2, 0.3}));
  c.only_gyr(
      [&](double t) -> Vector3d {
        const Vector3d w = c.motion.omega(t);
        return {.1 * w.x() * std::abs(w.x()), -.2 * w.y() * std::abs(w.y()),
                .3 * w.z() * std::abs(w.z())};
      },
      2e-5);
}

TEST(Effects, temperature_acts_on_the_bias_of_its_sensor) {
  const Vector3d slope(0.1, -0.2, 0.3);
  const std::vector<double> p = {0.1, -0.2, 0.3};
  const Comparison acc(make_effect("acc_temperature", p)), gyr(make_effect("gyro_temperature", p)),
      mag(make_effect("mag_temperature", p));
  const double mean = mean_over_samples(acc, warming_up);
  const auto expected = [&](double t) -> Vector3d { return slope * (warming_up(t) - mean); };
  acc.only_acc(expected);
  mag.only_mag(expected);
  gyr.only_gyr(expected, 1e-6);
}

TEST(Effects, lever_arm_is_the_acceleration_of_a_point_that_turns_about_the_pivot) {
  const Vector3d r(0.05, -0.03, 0.08);
  const Comparison c(make_effect("lever_arm", {0.05, -0.03, 0.08}));
  const auto point = [&](double t) -> Vector3d { return c.motion.nRb(t) * r; };
  constexpr double h = 1e-3;
  c.only_acc(
      [&](double t) -> Vector3d {
        return c.bRn(t) * (point(t + h) - 2.0 * point(t) + point(t - h)) / (h * h);
      },
      1e-4);
}

TEST(Effects, clock_scale_in_rotation_is_a_scale_of_the_gyroscope) {
  const double kappa = 0.02;
  const Simulation s = with(exact(MotionKind::kRotation), {make_effect("clock_scale", {kappa})});
  const Motion motion(exact(MotionKind::kRotation).motion, 4);
  for (std::size_t k = 0; k + 1 < s.truth.t.size(); k += 5) {
    const Quaterniond q = motion.nRb(1.02 * s.truth.t[k]);
    EXPECT_LT((s.truth.nRb[k].matrix() - q.toRotationMatrix()).norm(), 1e-12);
    // The rate that the file's clock sees, times 1 + S, is the reading.
    const Vector3d seen = (s.truth.nRb[k].inverse() * s.truth.nRb[k + 1]).Log() / 0.01;
    const Vector3d reading = s.recording.gyr.v[k] - s.truth.device.gyr_bias;
    EXPECT_LT(((1.0 - kappa / (1.0 + kappa)) * seen - reading).norm(), 2e-4);
    const Vector3d mag =
        s.truth.device.distortion * s.truth.nRb[k].unrotate(s.truth.device.unit_field());
    EXPECT_LT((s.recording.mag[0].v[k] - mag - s.truth.device.mag_bias).norm(), 1e-11);
  }
}

TEST(Effects, several_effects_add_up) {
  const Effect g = make_effect("gyro_g_sensitivity", {0, 1e-3, 0, 0, 0, 0, 0, 0, 0});
  const Effect n = make_effect("gyro_nonlinearity", {0.1, 0.1, 0.1});
  const auto none = simulate(exact()).recording.gyr.v;
  const auto one = with(exact(), {g}).recording.gyr.v, other = with(exact(), {n}).recording.gyr.v;
  const auto both = with(exact(), {g, n}).recording.gyr.v;
  for (std::size_t k = 0; k < none.size(); ++k) {
    EXPECT_LT((both[k] - one[k] - other[k] + none[k]).norm(), 1e-13);
  }
}

TEST(Effects, an_accelerometer_that_is_late_shows_an_earlier_force) {
  const Comparison c(make_effect("acc_time_offset", {0.007}));
  c.only_acc([&](double t) -> Vector3d { return c.f(t - 0.007) - c.f(t); });
}

TEST(Effects, gravity_adds_to_the_vertical) {
  const Comparison c(make_effect("gravity", {0.03}));
  c.only_acc([&](double t) -> Vector3d { return c.bRn(t) * Vector3d(0, 0, 0.03); });
}

TEST(Effects, changes_of_accelerometer_and_gyroscope_multiply_all_that_they_read) {
  const std::vector<double> p = {0.01, 0.02, 0.03,  -0.04, 0.05, 0.06,
                                 0.07, 0.08, -0.09, 10.0,  20.0};
  Matrix3d C;
  C << 0.01, 0.02, 0.03, -0.04, 0.05, 0.06, 0.07, 0.08, -0.09;
  const auto on = [](double t) { return t >= 10.0 && t < 20.0 ? 1.0 : 0.0; };
  const Comparison acc(make_effect("acc_change", p)), gyr(make_effect("gyro_change", p));
  acc.only_acc([&](double t) -> Vector3d { return on(t) * C * (acc.f(t) + acc.device.acc_bias); });
  gyr.only_gyr(
      [&](double t) -> Vector3d { return on(t) * C * (gyr.motion.omega(t) + gyr.device.gyr_bias); },
      1e-7);
}

}  // namespace
}  // namespace magimu::oracle
