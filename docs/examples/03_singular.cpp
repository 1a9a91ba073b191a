// SPDX-License-Identifier: BSD-3-Clause
// Example 3: data that cannot tell. A sensor with a magnetometer is turned about its vertical axis
// only. The vertical part of the field stays the same on the sensor's z axis, so that the third
// column of its distortion matrix adds the same vector to every sample, and so does its bias: only
// the sum of the two can be known. Three numbers are free.
//
// The library does not divide by such a direction. It finds it and names it; Levenberg-Marquardt
// still gives a fit, but Marginals refuse a covariance. The remedy is data that do tell, or a
// prior.
#include <cstdio>

#include <magimu/factors/keys.h>
#include <magimu/factors/magnetometer_factor.h>
#include <magimu/factors/prior_factor.h>
#include <magimu/solvers/levenberg_marquardt.h>
#include <magimu/solvers/marginals.h>

using namespace magimu;

constexpr double kDip = 60.0 * kDegree, kStrength_uT = 50.0;
const Vector3 kBias(4.0, -2.0, 7.0);  // uT

// Samples at the given orientations, which are known well; the field's strength is known as well.
void add_turn(FactorGraph& graph, Values& values, const Vector3& axis) {
  const Matrix3 D = kStrength_uT * Matrix3::Identity();
  for (int i = 0; i < 12; ++i) {
    const Rot3 nRb = Rot3::Exp(axis * (i * 30.0 * kDegree));
    const Key pose = R(values.size());
    values.insert(pose, nRb);
    graph.add(PriorFactor<Rot3>(pose, nRb, Noise<3>::isotropic(1e-3)));
    const Vector3 mag = magnetometer_model(nRb, D, kBias, kDip);
    graph.add(MagnetometerFactor(pose, key::distortion, key::mag_bias, key::dip, mag,
                                 Noise<3>::isotropic(0.3)));
  }
}

int main() {
  FactorGraph graph;
  Values start;
  start.insert(key::distortion, Matrix3(kStrength_uT * Matrix3::Identity()));
  start.insert(key::mag_bias, Vector3(0.0, 0.0, 0.0));
  start.insert(key::dip, kDip);
  graph.add(PriorFactor<double>(key::dip, kDip, Noise<1>::isotropic(0.01)));
  add_turn(graph, start, Vector3::UnitZ());

  std::printf("Turned about z only:\n");
  const Result stuck = GaussNewton(graph).optimize(start);
  std::printf("  Gauss-Newton: %s\n", stuck.message.c_str());
  const Result some = LevenbergMarquardt(graph).optimize(start);
  std::printf("  Levenberg-Marquardt: %s Cost %.2g.\n", some.message.c_str(), some.cost_final);
  const Marginals marginals(graph, some.values);
  std::printf("  directions left free: %zu\n", marginals.null_space().size());
  bool refused = false;
  try {
    marginals.covariance(key::mag_bias);
  } catch (const std::domain_error& error) {
    refused = true;
    std::printf("  covariance of the bias: %s\n", error.what());
  }

  std::printf("And about x:\n");
  add_turn(graph, start, Vector3::UnitX());
  const Result good = GaussNewton(graph).optimize(start);
  const Vector3 bias = good.values.at<Vector3>(key::mag_bias);
  const MatrixXd S = Marginals(graph, good.values).covariance(key::mag_bias);
  std::printf("  Gauss-Newton: %s\n", good.message.c_str());
  std::printf("  bias (%.3f, %.3f, %.3f) uT, sigmas (%.3f, %.3f, %.3f) uT\n", bias[0], bias[1],
              bias[2], std::sqrt(S(0, 0)), std::sqrt(S(1, 1)), std::sqrt(S(2, 2)));

  const bool named =
      stuck.reason == StopReason::kSingular && stuck.message.find("m0 along") != std::string::npos;
  return named && refused && marginals.null_space().size() == 3 && good.converged() &&
                 (bias - kBias).norm() < 1e-3
             ? 0
             : 1;
}
