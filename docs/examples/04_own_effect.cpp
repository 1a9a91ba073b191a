// SPDX-License-Identifier: BSD-3-Clause
// Example 4: an effect of one's own. Vibration makes some gyroscopes show a rate that grows with
// the square of the force along the axis: gyr_i + k_i f_i^2. One class says so; readings are
// simulated with it, and a fit of the model that has it finds k.
//
// In the library this class would be a file of factors/effects/gyroscope/, gyro_rectification, with
// `std::unique_ptr<Effect> make_gyro_rectification()` at its end; docs/effects.md tells what that
// gives.
#include <cmath>
#include <cstdio>

#include <magimu/calibration/fit/stage.h>
#include <magimu/calibration/model/extension.h>
#include <magimu/calibration/start/initialize.h>
#include <magimu/sim/simulate.h>
#include <magimu/solvers/marginals.h>

using namespace magimu;

class GyroRectification final : public Effect {
 public:
  GyroRectification()
      : Effect({.name = "gyro_rectification",
                .channel = Sensor::kGyr,
                .parameters = vector_parameters("k", "(rad/s)/(m/s^2)^2", 1e-3),
                .cause = "force, squared, shows as a rate",
                .separating_motion = "hold every face of the sensor up for some seconds"}) {}

  // Linear in k: the term itself is J k, which Effect does by default.
  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J = s.f.array().square().matrix().asDiagonal().toDenseMatrix();
  }
};

int main() {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 100.0;
  Simulation simulation = simulate(options);

  const auto effect = std::make_shared<GyroRectification>();
  const Vector3 k_true(2e-4, -1e-4, 1.5e-4);
  for (std::size_t i = 0; i < simulation.recording.gyr.size(); ++i) {
    SampleState state;
    state.f = simulation.truth.nRb[i].unrotate(Vector3(0, 0, options.gravity));
    simulation.recording.gyr.v[i] += effect->term(state, k_true);
  }

  // Without the effect, then with it from there.
  const std::vector<const Recording*> recordings = {&simulation.recording};
  ModelSpec spec;
  spec.gravity = options.gravity;
  spec.noise = simulation.truth.noise;
  Stage plain(recordings, spec, 2, {});
  const InitialGuess guess = initialize(recordings, {});
  plain.fit(initial_values(recordings, plain.plans(), guess, spec.motion), false);
  spec = plain.spec();
  spec.effects = {effect};
  Stage extended(recordings, spec, 2, {});
  extended.fit(carry_over(recordings, plain, extended), false);

  std::printf("cost without %.0f, with %.0f\n", plain.result().cost_final,
              extended.result().cost_final);
  const Values& values = extended.result().values;
  const Marginals marginals(extended.graph(), values);
  const std::vector<Key> keys = effect_keys({effect})[0];
  bool good = extended.result().converged();
  for (int i = 0; i < 3; ++i) {
    const double k = values.at<double>(keys[std::size_t(i)]);
    const double sigma = std::sqrt(marginals.covariance(keys[std::size_t(i)])(0, 0));
    std::printf("k[%d] = %9.2e +- %.1e, true %9.2e\n", i, k, sigma, k_true[i]);
    good = good && std::abs(k - k_true[i]) < 4.0 * sigma && sigma < 5e-5;
  }
  return good ? 0 : 1;
}
