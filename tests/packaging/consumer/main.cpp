// SPDX-License-Identifier: BSD-3-Clause
// A stranger's program: calibrates a simulated recording and says how strong the field is; and
// solves a problem of its own, with a factor of its own and matrices whose size is a multiple of 32
// bytes, which Eigen would align otherwise under -mavx.
#include <magimu/calibration/calibrate.h>
#include <magimu/graph/factor_graph.h>
#include <magimu/sim/simulate.h>
#include <magimu/solvers/levenberg_marquardt.h>
#include <magimu/solvers/marginals.h>
#include <cmath>
#include <cstdio>

using namespace magimu;

class Reading : public Factor<4, Vector4> {
 public:
  Reading(Key key, const Vector4& reading)
      : Factor({key}, Noise<4>::isotropic(0.5)), reading_(reading) {}
  template <class T>
  Vec<T, 4> residual(const Vec<T, 4>& x) const {
    return x - reading_.cast<T>();
  }

 private:
  Vector4 reading_;
};

static bool solves_a_problem_of_its_own() {
  constexpr Key kX{'x', 0};
  FactorGraph graph;
  Values start;
  start.insert(kX, Vector4(9.0, 9.0, 9.0, 9.0));
  Vector4 sum = Vector4::Zero();
  for (int k = 0; k < 16; ++k) {
    const Vector4 reading(k, 2.0 * k, -k, std::sin(k));
    sum += reading;
    graph.add(Reading(kX, reading));
  }
  const Result result = LevenbergMarquardt(graph).optimize(start);
  const MatrixXd covariance = Marginals(graph, result.values).covariance(kX);
  return result.converged() && (result.values.at<Vector4>(kX) - sum / 16.0).norm() < 1e-9 &&
         (covariance - 0.25 / 16.0 * MatrixXd::Identity(4, 4)).norm() < 1e-9;
}

int main() {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 50.0;
  options.duration_s = 40.0;
  const Simulation simulation = simulate(options);
  CalibrationOptions how;
  how.gravity = simulation.truth.gravity;
  const Calibration calibration = calibrate(simulation.recording, how);
  std::printf("%.1f uT, truly %.1f\n", calibration.strength_uT, simulation.truth.strength_uT);
  if (!solves_a_problem_of_its_own()) std::printf("a problem of its own is not solved\n");
  return std::abs(calibration.strength_uT - simulation.truth.strength_uT) < 0.1 &&
                 solves_a_problem_of_its_own()
             ? 0
             : 1;
}
