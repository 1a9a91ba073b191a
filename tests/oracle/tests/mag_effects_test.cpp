// SPDX-License-Identifier: BSD-3-Clause
// What the catalogue's effects add to the magnetometer, against docs/effects.md.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/oracle/mag_model.h"
#include "tests/oracle/tests/comparison.h"

namespace magimu::oracle {
namespace {

TEST(Effects, mag_time_offset_is_the_field_that_much_before) {
  Options options = exact();
  const Simulation late = with(options, {make_effect("mag_time_offset", {0.0137})});
  options.mag_first_s = 0.0063;  // sample k at 0.0063 + 0.01 k
  const Simulation shifted = simulate(options);
  for (std::size_t k = 2; k < 2900; k += 3) {
    EXPECT_LT((late.recording.mag[0].v[k] - shifted.recording.mag[0].v[k - 2]).norm(), 1e-10);
  }
  EXPECT_EQ(late.recording.gyr.v, shifted.recording.gyr.v);
}

TEST(Effects, mag_lag_solves_its_differential_equation) {
  Options options = exact();
  options.rate_hz = 1000.0;
  const Simulation s = with(options, {make_effect("mag_lag", {0.012})});
  const Simulation clean = simulate(options);
  const auto &lagged = s.recording.mag[0].v, &h = clean.recording.mag[0].v;
  double worst = 0.0;
  for (std::size_t k = 1; k + 1 < h.size(); ++k) {
    const Vector3d slope = (lagged[k + 1] - lagged[k - 1]) / 0.002;
    worst = std::max(worst, (0.012 * slope + lagged[k] - h[k]).norm());
  }
  EXPECT_LT(worst, 2e-3);
}

TEST(Effects, mag_lag_is_the_same_from_a_slow_magnetometer) {
  Options options = exact();
  const std::vector<Effect> lag = {make_effect("mag_lag", {0.012})};
  const Simulation dense = with(options, lag);
  options.mag_rate_hz = 20.0;
  const Simulation slow = with(options, lag);
  for (std::size_t k = 0; k < slow.recording.mag[0].size(); ++k) {
    EXPECT_LT((slow.recording.mag[0].v[k] - dense.recording.mag[0].v[5 * k]).norm(), 1e-10);
  }
}

TEST(Effects, mag_lag_equals_mag_time_offset_to_first_order) {
  const auto difference = [](double tau) {
    const auto lag = with(exact(), {make_effect("mag_lag", {tau})}).recording.mag[0].v;
    const auto offset = with(exact(), {make_effect("mag_time_offset", {tau})}).recording.mag[0].v;
    double worst = 0.0;
    for (std::size_t k = 0; k < lag.size(); ++k)
      worst = std::max(worst, (lag[k] - offset[k]).norm());
    return worst;
  };
  EXPECT_NEAR(difference(0.008) / difference(0.004), 4.0, 0.3);
}

TEST(Effects, mag_eddy_current) {
  const Comparison c(make_effect("mag_eddy_current", {1, 2, 3, 4, 5, 6, 7, 8, 9}));
  Matrix3d E;
  E << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  c.only_mag([&](double t) -> Vector3d { return E * c.motion.omega(t).cross(c.b(t)); });
}

TEST(Effects, mag_eddy_current_with_tau_D_is_the_offset_to_first_order) {
  Options options = exact();
  options.device = Device();
  const auto difference = [&](double tau) {
    const double e = 27.0 * tau;
    const auto eddy = with(options, {make_effect("mag_eddy_current", {e, 0, 0, 0, e, 0, 0, 0, e})});
    const auto late = with(options, {make_effect("mag_time_offset", {tau})});
    double worst = 0.0;
    for (std::size_t k = 0; k < eddy.recording.mag[0].size(); ++k) {
      worst = std::max(worst, (eddy.recording.mag[0].v[k] - late.recording.mag[0].v[k]).norm());
    }
    return worst;
  };
  EXPECT_NEAR(difference(0.002) / difference(0.001), 4.0, 0.2);
}

TEST(Effects, field_drift_turns_with_the_sensor_and_hard_iron_drift_does_not) {
  const std::vector<double> p = {0.1, 0.2, 0.3, -0.4, 0.5, 0.6, 0.7, 0.8, -0.9};
  const auto drift = [](double t) -> Vector3d {
    const double x = t / 15.0 - 1.0;
    return Vector3d(.1, .2, .3) * x + Vector3d(-.4, .5, .6) * (1.5 * x * x - 0.5) +
           Vector3d(.7, .8, -.9) * (2.5 * x * x * x - 1.5 * x);
  };
  const Comparison field(make_effect("field_drift", p)), iron(make_effect("hard_iron_drift", p));
  field.only_mag(
      [&](double t) -> Vector3d { return field.device.distortion * field.bRn(t) * drift(t); });
  iron.only_mag(drift);
}

TEST(Effects, hard_iron_change_lasts_from_t0_to_t1) {
  const Comparison c(make_effect("hard_iron_change", {5, -6, 7, 9.995, 15.005}));
  c.only_mag([&](double t) -> Vector3d {
    return t > 9.995 && t < 15.005 ? Vector3d(5, -6, 7) : Vector3d(0, 0, 0);
  });
  const double never = std::numeric_limits<double>::infinity();
  const Comparison all(make_effect("hard_iron_change", {5, -6, 7, -1, never}));
  all.only_mag([](double) -> Vector3d { return Vector3d(5, -6, 7); });
}

TEST(Effects, a_change_of_the_field_turns_with_the_sensor) {
  const Comparison c(make_effect("field_change", {0.1, -0.2, 0.3, 9.995, 15.005}));
  c.only_mag([&](double t) -> Vector3d {
    if (t < 9.995 || t > 15.005) return Vector3d(0, 0, 0);
    return c.device.distortion * c.bRn(t) * Vector3d(0.1, -0.2, 0.3);
  });
}

TEST(Effects, a_change_of_the_magnetometer_multiplies_all_that_it_reads) {
  const Comparison c(make_effect(
      "mag_change", {0.01, 0.02, 0.03, -0.04, 0.05, 0.06, 0.07, 0.08, -0.09, 9.995, 15.005}));
  Matrix3d C;
  C << 0.01, 0.02, 0.03, -0.04, 0.05, 0.06, 0.07, 0.08, -0.09;
  c.only_mag([&](double t) -> Vector3d {
    const double on = t > 9.995 && t < 15.005 ? 1.0 : 0.0;
    return on * C * (c.device.distortion * c.b(t) + c.device.mag_bias);
  });
}

TEST(Effects, a_clock_of_its_own_shows_the_field_up_to_a_period_ago) {
  const Comparison c(make_effect("mag_own_clock", {0.0066, 0.3}));
  c.only_mag([&](double t) -> Vector3d {
    const double age = std::fmod(t + 0.3 * 0.0066, 0.0066);
    return c.device.distortion * (c.b(t - age) - c.b(t));
  });
}

TEST(Effects, field_gradient) {
  const Comparison c(make_effect("field_gradient", {10, 20, 30, 40, 50}));
  Matrix3d G;
  G << 10, 30, 40, 30, 20, 50, 40, 50, -30;
  const Vector3d mean =
      mean_over_samples(c, [&](double t) -> Vector3d { return c.motion.position(t); });
  const double strength = std::cbrt(c.device.distortion.determinant());
  c.only_mag([&](double t) -> Vector3d {
    return c.device.distortion * c.bRn(t) * G * (c.motion.position(t) - mean) / strength;
  });
}

TEST(Effects, a_dipoles_field_has_its_textbook_values_and_neither_divergence_nor_curl) {
  const Vector3d up(0, 0, 2);
  EXPECT_LT((dipole_field_uT(up, {0, 0, 0.5}) - Vector3d(0, 0, 0.1 * 2 * 2 / 0.125)).norm(), 1e-14);
  EXPECT_LT((dipole_field_uT(up, {0.5, 0, 0}) - Vector3d(0, 0, -0.1 * 2 / 0.125)).norm(), 1e-14);
  Matrix3d gradient;
  for (int i = 0; i < 3; ++i) {
    const Vector3d at(0.3, -0.4, 0.2), h = 1e-5 * Vector3d::Unit(i);
    gradient.col(i) = (dipole_field_uT(up, at + h) - dipole_field_uT(up, at - h)) / 2e-5;
  }
  EXPECT_NEAR(gradient.trace(), 0.0, 1e-6);
  EXPECT_LT((gradient - gradient.transpose()).norm(), 1e-6);
  EXPECT_GT(gradient.norm(), 1.0);
}

TEST(Effects, stationary_source_is_a_dipole_that_the_sensor_moves_by) {
  Options options = exact();
  options.motion.carry_m = 0.3;
  const Comparison c(make_effect("stationary_source", {0.5, -0.4, 0.3, 0.5, 1, -2}), options);
  const double strength = std::cbrt(c.device.distortion.determinant());
  c.only_mag([&](double t) -> Vector3d {
    const Vector3d from = c.motion.position(t) - Vector3d(0.5, -0.4, 0.3), m(0.5, 1, -2);
    const double r = from.norm();
    const Vector3d field = 0.1 * (3.0 * from * from.dot(m) / std::pow(r, 5) - m / std::pow(r, 3));
    return c.device.distortion * c.bRn(t) * field / strength;
  });
}

TEST(Effects, mag_nonlinearity) {
  const Comparison c(make_effect("mag_nonlinearity", {0.1, -0.2, 0.3}));
  c.only_mag([&](double t) -> Vector3d {
    const Vector3d B = c.device.distortion * c.b(t);
    return {.1 * B.x() * B.x() * B.x() / 2500, -.2 * B.y() * B.y() * B.y() / 2500,
            .3 * B.z() * B.z() * B.z() / 2500};
  });
}

TEST(Effects, mag_current_and_mains_interference) {
  const Comparison current(make_effect("mag_current", {0.5, -1, 2}));
  current.only_mag([](double t) -> Vector3d { return Vector3d(.5, -1, 2) * switching_current(t); });
  const Comparison mains(make_effect("mains_interference", {1, 2, 3, 4, 5, 6, 17.3}));
  mains.only_mag([](double t) -> Vector3d {
    const double angle = 2.0 * std::numbers::pi * 17.3 * t;
    return Vector3d(1, 2, 3) * std::cos(angle) + Vector3d(4, 5, 6) * std::sin(angle);
  });
}

}  // namespace
}  // namespace magimu::oracle
