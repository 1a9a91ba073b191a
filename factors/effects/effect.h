// SPDX-License-Identifier: BSD-3-Clause
// An effect is one thing that the basic sensor models leave out: what it adds to a sensor's reading
// (docs/effects.md has one equation each). It is defined once, here, and serves three ends: the
// graph estimates its parameters (calibration/model/extension.h), the scan asks whether the data
// want it (calibration/scan/scan.h), and the simulation adds it to readings (sim/hidden_effects.h).
//
//   reading = basic model + term(state, theta)      acc: m/s^2, gyr: rad/s, mag: uT
//
// To add one: write factors/effects/<room>/<name>.cpp with a class derived from Effect, and
// `std::unique_ptr<Effect> make_<name>()` at its end. The build finds it by the file's name; a test
// checks its Jacobian against numerical derivatives.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "graph/rot3.h"
#include "graph/sensor.h"

namespace magimu {

// What the sensors experience at one instant, as the basic models have it. IMU frame unless said
// otherwise; of the gyroscope's samples: the mean over the sample's interval.
struct SampleState {
  double t = 0.0;                               // s
  int recording = 0;                            // which of several this is; its parts share it
  double u = 0.0;                               // -1 at the recording's start, 1 at its end
  double duration_s = 0.0;                      // of the recording
  Rot3 nRb;                                     // IMU frame to n
  Vector3 omega = Vector3::Zero();              // rate, rad/s
  Vector3 omega_rate = Vector3::Zero();         // its derivative, rad/s^2
  Vector3 f = Vector3::Zero();                  // specific force, m/s^2
  Vector3 b = Vector3::Zero();                  // unit field R' m(alpha)
  Matrix3 D = Matrix3::Identity();              // distortion, uT
  double strength_uT = 50.0;                    // cube root of det D
  Vector3 bias = Vector3::Zero();               // of the sensor itself: o_a, o_w or o_m
  double temperature = 0.0;                     // less its mean, K
  double current = 0.0;                         // A
  Vector3 position = Vector3::Zero();           // in n, m
  Vector3 position_mean = Vector3::Zero();      // over the recording
  Vector3 neighbour = Vector3::Zero();          // what another magnetometer beside it reads, uT
  double delay_s = 0.0;                         // by which the model has the magnetometer late
  std::function<Vector3(double)> field_before;  // b so many seconds earlier
  std::function<Vector3(double)> force_change;  // f so many seconds earlier, less f
};

using EffectJacobian = Eigen::Ref<Eigen::Matrix<double, 3, Eigen::Dynamic>>;

class Effect {
 public:
  struct Parameter {
    std::string name, unit;
    double prior_sigma;  // of usual parts and surroundings; the prior is N(0, prior_sigma^2)
  };
  struct Description {
    std::string name = {};  // as in docs/effects.md
    Sensor channel = Sensor::kMag;
    std::vector<Parameter> parameters = {};
    std::string cause = {};  // half a sentence: "the magnetometer lags the gyroscope"
    std::string needs = {};  // auxiliary column: "temp", "current", "pos"; empty: none
    // Simpler causes that are special cases of this one.
    std::vector<std::string> contains = {};
    // Causes that no motion, or only the given one, tells from this one.
    std::vector<std::string> same_class = {};
    std::string separating_motion = {};  // what makes its parameters visible
    // Under the hand-held model it cannot be told from the motion.
    bool rotation_only = false;
    // A walk: states with a prior that has a density to be estimated.
    bool random_process = false;
    // Its prior's size was found by the search, which is what a finding of it tells.
    bool proper_prior = false;
    // Its term follows from time, specific force, temperature and current: not from attitude, rate
    // or field, which are most of the work of finding a state.
    bool without_attitude = false;
    // It depends on the position; what it changes by with that is by_position().
    bool of_position = false;
  };

  explicit Effect(Description description) : description_(std::move(description)) {}
  virtual ~Effect() = default;

  const Description& description() const { return description_; }
  const std::string& name() const { return description_.name; }
  Sensor channel() const { return description_.channel; }
  int size() const { return int(description_.parameters.size()); }

  // d term / d theta, 3 x size().
  virtual void jacobian(const SampleState& state, const VectorXd& theta,
                        EffectJacobian J) const = 0;
  // What is added to the reading. By default linear: J theta.
  virtual Vector3 term(const SampleState& state, const VectorXd& theta) const;
  // d term / d position, uT/m or the like; only where description().of_position.
  virtual Matrix3 by_position(const SampleState& state, const VectorXd& theta) const;
  // By how much it makes the readings late, s.
  virtual double delay(const VectorXd& /*theta*/) const { return 0.0; }
  // Prior standard deviations; a random process may have them depend on the recording's length.
  virtual VectorXd prior_sigma(double duration_s) const;
  // The same family (a drift, say) with so many terms in each direction; null: it is none.
  virtual std::shared_ptr<const Effect> with_terms(int terms) const;
  // "The magnetometer lags the gyroscope by 11.0 +- 0.2 ms."
  virtual std::string sentence(const VectorXd& theta, const VectorXd& sigma) const;

 private:
  Description description_;
};

// Every effect with a term of its own, by name; families (drifts) with three terms.
const std::vector<std::shared_ptr<const Effect>>& effect_catalogue();
// One of these; null if there is none of that name.
std::shared_ptr<const Effect> find_effect(const std::string& name);

// Legendre polynomial P_j(u).
double legendre(int j, double u);

// Parameters of a vector, "name[0]" and so on, or of a matrix row by row, "name[0][1]".
std::vector<Effect::Parameter> vector_parameters(const std::string& name, const std::string& unit,
                                                 double prior_sigma);
std::vector<Effect::Parameter> matrix_parameters(const std::string& name, const std::string& unit,
                                                 double prior_sigma);
// d (M x) / d M, M row by row.
void matrix_jacobian(const Vector3& x, EffectJacobian J);

}  // namespace magimu
