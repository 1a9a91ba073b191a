// SPDX-License-Identifier: BSD-3-Clause
// Example 1: rotation averaging. A camera turns once around in 24 poses; neighbours, and poses that
// see the same scene again, measure the rotation between them. What are the orientations?
//
// A graph is a sum of factors (what was measured, and how well); Values hold the unknowns (first a
// guess, then the answer); an optimizer moves Values to where the factors agree best; Marginals
// tell how sure that is.
#include <Eigen/Cholesky>
#include <cstdio>
#include <random>

#include <magimu/factors/keys.h>
#include <magimu/factors/prior_factor.h>
#include <magimu/factors/relative_rotation_factor.h>
#include <magimu/solvers/levenberg_marquardt.h>
#include <magimu/solvers/marginals.h>

using namespace magimu;

constexpr int kPoses = 24;
constexpr double kSigma = 0.01;  // rad, of one measurement about each axis

// The truth, which only the simulation knows: one turn about z, nodding a little.
Rot3 true_pose(int i) {
  const double angle = 2.0 * EIGEN_PI * i / kPoses;
  return Rot3::Exp(Vector3(0.0, 0.0, angle)) * Rot3::Exp(Vector3(0.2 * std::sin(3 * angle), 0, 0));
}

int main() {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  const auto noise = [&](double s) {
    return Rot3::Exp(Vector3(s * normal(engine), s * normal(engine), s * normal(engine)));
  };

  // What was measured: i R j, the rotation from the frame of pose j to that of pose i.
  FactorGraph graph;
  const auto measure = [&](int i, int j) {
    const Rot3 iRj = true_pose(i).inverse() * true_pose(j) * noise(kSigma);
    graph.add(RelativeRotationFactor(R(i), R(j), iRj, Noise<3>::isotropic(kSigma)));
  };
  for (int i = 0; i + 1 < kPoses; ++i) measure(i, i + 1);     // along the way
  for (int i = 0; i + 4 < kPoses; i += 2) measure(i, i + 4);  // overlapping views
  measure(kPoses - 1, 0);                                     // the loop closes
  // Measurements between poses say nothing of north: one pose must be given.
  graph.add(PriorFactor<Rot3>(R(0), true_pose(0), Noise<3>::isotropic(1e-4)));

  // A rough start: every pose off by some 0.3 rad about each axis, 30 times the noise.
  Values guess;
  for (int i = 0; i < kPoses; ++i) guess.insert(R(i), true_pose(i) * noise(0.3));

  const Result result = LevenbergMarquardt(graph).optimize(guess);
  std::printf("%s\n", result.message.c_str());
  for (const IterationRecord& step : result.trace) {
    std::printf("  step %d: cost %.6f, %.1e sigmas\n", step.iteration, step.cost, step.step_sigma);
  }

  // The covariance of a rotation is that of the small rotation, from the left, which leads from
  // the estimate to the truth.
  const Marginals marginals(graph, result.values);
  double worst = 0.0;
  for (int i = 1; i < kPoses; ++i) {
    const Vector3 error = (true_pose(i) * result.values.at<Rot3>(R(i)).inverse()).Log();
    const MatrixXd S = marginals.covariance(R(i));
    worst = std::max(worst, std::sqrt(error.dot(S.llt().solve(error))));
    if (i % 6 == 0) {
      std::printf("pose %2d: off by %.4f rad, expected about %.4f rad\n", i, error.norm(),
                  std::sqrt(S.trace()));
    }
  }
  std::printf("largest error: %.1f sigmas\n", worst);
  return result.converged() && worst < 4.5 ? 0 : 1;  // chi-square, 3 degrees: 1 in 6000 poses
}
