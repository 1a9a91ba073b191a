// SPDX-License-Identifier: BSD-3-Clause
// A motion that hardly tells some parameters leaves them on a curve, and the sigmas know.
#include "calibration/fit/bent_posterior.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "calibration/calibrate.h"
#include "study/error_statistics.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

constexpr double kDegrees = 0.017453292519943295;

// A sensor that lies in few attitudes, half a minute in all, and turns from one to the next.
struct FewAttitudes {
  Recording recording;
  SensorParameters truth;
};

FewAttitudes few_attitudes(std::uint64_t seed) {
  constexpr double kRate = 50.0, kStay = 7.0, kTurn = 1.5;
  const Vector3 turns[] = {{22.0, -10.0, 30.0}, {-5.0, 45.0, 15.0}, {8.0, 40.0, -25.0}};
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double size) {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Vector3(size * Vector3(x, y, z));
  };
  FewAttitudes out;
  const Matrix3 D =
      34.0 * (Matrix3() << 1.02, 0.01, -0.01, 0.0, 0.98, 0.02, 0.01, 0.0, 1.01).finished();
  out.truth.acc_bias = noise(0.1);
  out.truth.gyr_bias = noise(0.01);
  out.truth.dip_rad = -62.0 * kDegrees;
  out.truth.mag = {{D, noise(5.0)}};
  const Vector3 field(0.0, std::cos(out.truth.dip_rad), -std::sin(out.truth.dip_rad));
  Recording& r = out.recording;
  r.name = "few attitudes";
  r.mag_names = {"mag"};
  r.mag.resize(1);
  Rot3 nRb = Rot3::Exp(Vector3(0.05, -0.03, 1.0));
  const double end = 4.0 * kStay + 3.0 * kTurn;
  for (int k = 0; double(k) / kRate < end; ++k) {
    const double t = double(k) / kRate, in_turn = std::fmod(t, kStay + kTurn) - kStay;
    Vector3 rate = Vector3::Zero();
    if (in_turn >= 0.0) {  // from rest to rest
      const double share = std::sin(M_PI * in_turn / kTurn);
      rate = turns[int(t / (kStay + kTurn))] * kDegrees * (2.0 * share * share / kTurn);
    }
    const auto add = [&](VectorSeries& s, const Vector3& v) {
      s.t.push_back(t);
      s.v.push_back(v);
    };
    add(r.acc,
        nRb.unrotate(Vector3(0.0, 0.0, kStandardGravity)) + out.truth.acc_bias + noise(0.012));
    add(r.gyr, rate + out.truth.gyr_bias + noise(1.4e-3));
    if (k % 2 == 0) add(r.mag[0], D * nRb.unrotate(field) + out.truth.mag[0].bias + noise(0.5));
    nRb = (nRb * Rot3::Exp(Vector3(rate / kRate))).normalized();
  }
  return out;
}

double distance(const Calibration& c, const SensorParameters& truth) {
  const VectorXd e =
      in_calibration_order(c).head(19) - in_calibration_order(truth, {truth.dip_rad});
  return e.dot(c.covariance.topLeftCorner(19, 19).ldlt().solve(e));
}

bool tells_of_a_curve(const Calibration& c) {
  return std::ranges::any_of(c.checks, [](const Check& k) { return k.name == "curvature"; });
}

TEST(BentPosterior, a_sensor_that_turned_well_leaves_no_curve) {
  oracle::Options o;
  o.seed = 5;
  o.rate_hz = 50.0;
  o.noise = oracle::kRealisticDensities;
  o.motion.duration_s = 60.0;
  EXPECT_FALSE(tells_of_a_curve(calibrate(oracle::simulate(o).recording)));
}

// Chi-square with 19 degrees of freedom: 1 in 100,000 beyond 58.
TEST(BentPosterior, errors_along_the_curve_are_within_the_sigmas) {
  int curves = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const FewAttitudes s = few_attitudes(seed);
    const Calibration c = calibrate(s.recording);
    if (c.trust.verdict == Verdict::kNo) continue;
    curves += tells_of_a_curve(c) ? 1 : 0;
    EXPECT_LT(distance(c, s.truth), 58.0) << seed;
  }
  EXPECT_GE(curves, 4);
}

}  // namespace
}  // namespace magimu
