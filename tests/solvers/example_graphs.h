// SPDX-License-Identifier: BSD-3-Clause
// Two graphs on which everything must work: a chain of poses that all share calibration parameters,
// and a pose graph with loops. Noisy measurements of a random truth; a start away from it.
#pragma once

#include "factors/accelerometer_factor.h"
#include "factors/gyroscope_factor.h"
#include "factors/keys.h"
#include "factors/magnetometer_factor.h"
#include "factors/prior_factor.h"
#include "factors/relative_rotation_factor.h"
#include "solvers/back_ends.h"
#include "solvers/linear/linear_solver.h"
#include "tests/factors/jacobian_check.h"
#include "tests/graph/dense.h"

namespace magimu::test {

struct Problem {
  FactorGraph graph;
  Values truth, start;
};

inline VectorXd random_delta(RandomValue& random, int n, double scale) {
  return VectorXd::NullaryExpr(n, [&] { return random.number(scale); });
}
inline Values moved(const Values& values, const VectorXd& delta) {
  return values.retract({delta.data(), std::size_t(delta.size())});
}

// Accelerometer, magnetometer and gyroscope on n poses; biases, distortion and dip are unknown.
inline Problem chain_with_globals(unsigned seed, int n) {
  constexpr double kDt = 0.1, kAcc = 0.05, kGyr = 0.02, kMag = 0.3;
  RandomValue random(seed);
  Problem p;
  Rot3 nRb = random.rotation();
  for (int i = 0; i < n; ++i, nRb = nRb * Rot3::Exp(random.vector3(0.3))) {
    p.truth.insert(R(i), nRb);
  }
  const Vector3 acc_bias = random.vector3(0.2), gyr_bias = random.vector3(0.1);
  const Matrix3 D = 50.0 * Matrix3::Identity() + random.matrix3(3.0);
  const Vector3 mag_bias = random.vector3(20.0);
  const double dip = 1.0;
  p.truth.insert(key::acc_bias, acc_bias);
  p.truth.insert(key::gyr_bias, gyr_bias);
  p.truth.insert(key::distortion, D);
  p.truth.insert(key::mag_bias, mag_bias);
  p.truth.insert(key::dip, dip);
  const Vector3 g_n = gravity_n(kStandardGravity);
  for (int i = 0; i < n; ++i) {
    const Rot3 at = p.truth.at<Rot3>(R(i));
    const Vector3 acc = accelerometer_model(at, acc_bias, g_n) + random.vector3(kAcc);
    const Vector3 mag = magnetometer_model(at, D, mag_bias, dip) + random.vector3(kMag);
    p.graph.add(AccelerometerFactor(R(i), key::acc_bias, acc, g_n, Noise<3>::isotropic(kAcc)));
    p.graph.add(MagnetometerFactor(R(i), key::distortion, key::mag_bias, key::dip, mag,
                                   Noise<3>::isotropic(kMag)));
    if (i + 1 == n) break;
    const Vector3 step = (at.inverse() * p.truth.at<Rot3>(R(i + 1))).Log();
    const Vector3 gyr = step / kDt + gyr_bias + random.vector3(kGyr);
    p.graph.add(
        GyroscopeFactor(R(i), R(i + 1), key::gyr_bias, gyr, kDt, Noise<3>::isotropic(kGyr)));
  }
  p.start = moved(p.truth, random_delta(random, p.truth.dim(), 0.05));
  return p;
}

// n poses in a row and loops closed at random; a prior on the first pose, if wanted.
inline Problem pose_graph(unsigned seed, int n, bool prior = true) {
  constexpr double kSigma = 0.02;
  const Noise<3> noise = Noise<3>::isotropic(kSigma);
  RandomValue random(seed);
  Problem p;
  for (int i = 0; i < n; ++i) p.truth.insert(R(i), random.rotation());
  const auto measure = [&](int i, int j) {
    const Rot3 iRj = p.truth.at<Rot3>(R(i)).inverse() * p.truth.at<Rot3>(R(j));
    p.graph.add(RelativeRotationFactor(R(i), R(j), iRj * Rot3::Exp(random.vector3(kSigma)), noise));
  };
  if (prior) p.graph.add(PriorFactor<Rot3>(R(0), p.truth.at<Rot3>(R(0)), noise));
  for (int i = 0; i + 1 < n; ++i) measure(i, i + 1);
  for (int i = 0; i + 7 < n; i += 3)
    measure(i, (i * 17 + 5) % (n - 6) == i ? i + 6 : (i * 17 + 5) % (n - 6));
  p.start = moved(p.truth, random_delta(random, p.truth.dim(), 0.1));
  return p;
}

// The back ends that were built in, and the choice that kAuto makes for each graph.
inline std::vector<Backend> backends() {
  std::vector<Backend> out;
  for (const Backend b : {Backend::kAuto, Backend::kCholmod, Backend::kSpqr, Backend::kEigen}) {
    try {
      make_linear_solver(b);
      out.push_back(b);
    } catch (const std::invalid_argument&) {
      continue;  // built without SuiteSparse
    }
  }
  return out;
}

// For the names of tests that run on each back end.
inline std::string backend_name(const testing::TestParamInfo<Backend>& backend) {
  return to_string(backend.param);
}

// The distance between two points in standard deviations: the length of their difference in the
// metric J'J of the graph at a.
inline double sigmas_between(const FactorGraph& graph, const Values& a, const Values& b) {
  LinearSystem system(graph, a);
  system.linearize(a);
  return system.multiply(a.local_coordinates(b)).norm();
}

}  // namespace magimu::test
