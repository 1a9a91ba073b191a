// SPDX-License-Identifier: BSD-3-Clause
// What holds of every effect of the catalogue: its name and parameters are those of the table
// below, its Jacobian is the derivative of its term, and without its parameters it is not there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "factors/effects/catalogue.h"
#include "tests/factors/jacobian_check.h"

namespace magimu {
namespace {

using test::RandomValue;

struct Entry {
  int parameters;
  Sensor channel;
  std::string first_unit, needs;
};
// The table of docs/effects.md; of families and searches the parameters that a fit estimates.
const std::map<std::string, Entry>& documented() {
  constexpr Sensor acc = Sensor::kAcc, gyr = Sensor::kGyr, mag = Sensor::kMag;
  static const std::map<std::string, Entry> table = {
      {"acc_scale_misalignment", {6, acc, "1", ""}},
      {"gyro_scale_misalignment", {9, gyr, "1", ""}},
      {"clock_scale", {1, gyr, "1", ""}},
      {"gyro_g_sensitivity", {9, gyr, "(rad/s)/(m/s^2)", ""}},
      {"gyro_nonlinearity", {3, gyr, "s/rad", ""}},
      {"gyro_bias_drift", {9, gyr, "rad/s", ""}},
      {"gyro_temperature", {3, gyr, "rad/s/K", "temp"}},
      {"acc_temperature", {3, acc, "m/s^2/K", "temp"}},
      {"mag_temperature", {3, mag, "uT/K", "temp"}},
      {"lever_arm", {3, acc, "m", ""}},
      {"mag_time_offset", {1, mag, "s", ""}},
      {"mag_lag", {1, mag, "s", ""}},
      {"acc_nonlinearity", {3, acc, "1", ""}},
      {"mag_bandwidth", {1, mag, "s^2", ""}},
      {"acc_bandwidth", {1, acc, "s^2", ""}},
      {"mag_gain_drift", {9, mag, "1", ""}},
      {"gyro_gain_drift", {9, gyr, "1", ""}},
      {"acc_gain_drift", {12, acc, "1", ""}},
      {"mag_axis_time_offset", {3, mag, "s", ""}},
      {"mag_eddy_current", {9, mag, "uT s", ""}},
      {"field_drift", {9, mag, "1", ""}},
      {"hard_iron_drift", {9, mag, "uT", ""}},
      {"hard_iron_change", {3, mag, "uT", ""}},
      {"field_change", {3, mag, "1", ""}},
      {"field_gradient", {5, mag, "uT/m", "pos"}},
      {"stationary_source", {6, mag, "m", "pos"}},
      {"mag_nonlinearity", {3, mag, "1", ""}},
      {"mag_current", {3, mag, "uT/A", "current"}},
      {"mains_interference", {6, mag, "uT", ""}},
      {"acc_time_offset", {1, acc, "s", ""}},
      {"gravity", {1, acc, "m/s^2", ""}},
      {"mag_own_clock", {2, mag, "s", ""}},
      {"mag_coupling", {9, mag, "1", ""}},
      {"gyro_bias_change", {3, gyr, "rad/s", ""}},
      {"acc_bias_change", {3, acc, "m/s^2", ""}},
      {"acc_bias_drift", {9, acc, "m/s^2", ""}},
      {"mag_change", {9, mag, "1", ""}},
      {"gyro_change", {9, gyr, "1", ""}},
      {"acc_change", {9, acc, "1", ""}}};
  return table;
}

SampleState random_state(RandomValue& random) {
  SampleState s;
  s.u = std::tanh(random.number());
  s.duration_s = 60.0;
  s.t = 30.0 * (s.u + 1.0);
  s.nRb = random.rotation();
  s.omega = random.vector3(2.0);
  s.omega_rate = random.vector3(5.0);
  s.f = random.vector3(10.0);
  s.b = random.vector3().normalized();
  s.D = 45.0 * Matrix3::Identity() + random.matrix3(3.0);
  s.strength_uT = std::cbrt(s.D.determinant());
  s.temperature = random.number(5.0);
  s.current = random.number();
  s.position = random.vector3(0.2);
  s.bias = random.vector3();
  s.neighbour = random.vector3(40.0);
  s.force_change = [omega = s.omega, f = s.f](double delay) -> Vector3 {
    return Rot3::Exp(Vector3(omega * delay)) * f - f;
  };
  // At a constant rate; R(t - delay) = R(t) Exp(-omega delay).
  s.field_before = [omega = s.omega, b = s.b](double delay) {
    return Rot3::Exp(Vector3(omega * delay)) * b;
  };
  return s;
}

// Of usual size; a delay is positive, and a source stands off the sensor.
VectorXd random_parameters(const Effect& effect, RandomValue& random) {
  VectorXd theta(effect.size());
  for (int i = 0; i < effect.size(); ++i) {
    theta[i] = random.number(effect.description().parameters[std::size_t(i)].prior_sigma);
  }
  if (effect.name() == "mag_own_clock") theta = theta.cwiseAbs();
  if (effect.name() == "mag_lag" || effect.name().ends_with("time_offset"))
    theta = theta.cwiseAbs();
  if (effect.name() == "stationary_source" && effect.size() == 6) {
    theta.head<3>() = 1.5 * random.vector3().normalized();
  }
  return theta;
}

// The catalogue, and those that are made for given times, places and frequencies.
std::vector<std::shared_ptr<const Effect>> all_effects() {
  std::vector<std::shared_ptr<const Effect>> all = effect_catalogue();
  for (const std::string& name : change_names()) {
    for (const ChangeForm form : forms_of_change(name)) {
      all.push_back(make_change(name, form, {.begin = {0, 10.0}, .end = {0, 40.0}}));
    }
  }
  all.push_back(make_gyro_bias_walk(7, 1e-4));
  all.push_back(make_stationary_source_at({0.8, -0.7, 0.5}));
  all.push_back(make_mains_at(33.3));
  all.push_back(find_effect("field_drift")->with_terms(1));
  return all;
}

MatrixXd jacobian(const Effect& effect, const SampleState& s, const VectorXd& theta) {
  // Filled, so that an entry that is left out shows.
  Eigen::Matrix<double, 3, Eigen::Dynamic> J =
      Eigen::Matrix<double, 3, Eigen::Dynamic>::Constant(3, effect.size(), 1e9);
  effect.jacobian(s, theta, J);
  return J;
}

TEST(Effects, have_the_names_parameters_units_and_needs_of_the_contract) {
  std::set<std::string> names;
  for (const auto& effect : effect_catalogue()) {
    const std::string& name = effect->name();
    EXPECT_TRUE(names.insert(name).second) << name << " is there twice";
    ASSERT_TRUE(documented().contains(name)) << name;
    const Entry& entry = documented().at(name);
    EXPECT_EQ(effect->size(), entry.parameters) << name;
    EXPECT_EQ(effect->channel(), entry.channel) << name;
    EXPECT_EQ(effect->description().parameters.front().unit, entry.first_unit) << name;
    EXPECT_EQ(effect->description().needs, entry.needs) << name;
    EXPECT_EQ(find_effect(name), effect);
  }
  EXPECT_EQ(names.size(), documented().size());
  EXPECT_EQ(find_effect("gremlins"), nullptr);
}

TEST(Effects, describe_themselves) {
  for (const auto& effect : effect_catalogue()) {
    const Effect::Description& d = effect->description();
    EXPECT_FALSE(d.cause.empty()) << d.name;
    EXPECT_FALSE(d.separating_motion.empty()) << d.name;
    std::set<std::string> names;
    for (const auto& p : d.parameters) EXPECT_TRUE(names.insert(p.name).second) << p.name;
    for (const auto& list : {d.contains, d.same_class}) {
      for (const std::string& other : list) EXPECT_NE(find_effect(other), nullptr) << other;
    }
    const VectorXd sigma = effect->prior_sigma(60.0);
    ASSERT_EQ(sigma.size(), effect->size());
    EXPECT_GT(sigma.minCoeff(), 0.0) << d.name;
    const std::string sentence = effect->sentence(sigma, 0.1 * sigma);
    EXPECT_TRUE(std::isupper(sentence.front())) << sentence;
    EXPECT_EQ(sentence.back(), '.') << sentence;
  }
}

TEST(Effects, have_the_jacobian_of_their_term) {
  RandomValue random(3);
  for (const auto& effect : all_effects()) {
    if (effect->name() == "mag_own_clock") continue;  // below
    for (int trial = 0; trial < 20; ++trial) {
      const SampleState s = random_state(random);
      const VectorXd theta = random_parameters(*effect, random);
      const MatrixXd J = jacobian(*effect, s, theta);
      for (int i = 0; i < effect->size(); ++i) {
        const double step = 1e-4 * effect->description().parameters[std::size_t(i)].prior_sigma;
        VectorXd more = theta, less = theta;
        more[i] += step;
        less[i] -= step;
        const Vector3 numerical =
            (effect->term(s, more) - effect->term(s, less)) / (more[i] - less[i]);
        EXPECT_LT((J.col(i) - numerical).norm(), 1e-6 * std::max(1.0, J.norm()))
            << effect->name() << " " << i;
      }
    }
  }
}

TEST(Effects, are_linear_but_for_those_that_delay_scale_time_or_have_a_place) {
  const std::set<std::string> curved = {
      "mag_time_offset",   "mag_axis_time_offset", "mag_lag",      "clock_scale",
      "stationary_source", "acc_time_offset",      "mag_own_clock"};
  RandomValue random(4);
  for (const auto& effect : effect_catalogue()) {
    const SampleState s = random_state(random);
    const VectorXd a = random_parameters(*effect, random), b = random_parameters(*effect, random);
    const Vector3 together = effect->term(s, a + 2.0 * b);
    const Vector3 apart = effect->term(s, a) + 2.0 * effect->term(s, b);
    const bool linear = (together - apart).norm() < 1e-12 * (1.0 + apart.norm());
    EXPECT_EQ(linear, !curved.contains(effect->name())) << effect->name();
  }
}

// States are found without attitudes for these (SensedMotion::state_without_attitude).
TEST(Effects, that_do_without_an_attitude_are_the_same_at_any) {
  RandomValue random(8);
  int without = 0;
  for (const auto& effect : effect_catalogue()) {
    if (!effect->description().without_attitude) continue;
    ++without;
    const VectorXd theta = VectorXd::LinSpaced(effect->size(), 0.3, 1.2);
    const SampleState s = random_state(random);
    SampleState alone;
    alone.t = s.t;
    alone.u = s.u;
    alone.duration_s = s.duration_s;
    alone.f = s.f;
    alone.temperature = s.temperature;
    alone.current = s.current;
    alone.bias = s.bias;
    EXPECT_EQ(effect->term(alone, theta), effect->term(s, theta)) << effect->name();
    MatrixXd J(3, effect->size()), of_alone(3, effect->size());
    effect->jacobian(s, theta, J);
    effect->jacobian(alone, theta, of_alone);
    EXPECT_EQ(of_alone, J) << effect->name();
  }
  EXPECT_GE(without, 8);
}

TEST(Effects, are_not_there_without_their_parameters) {
  RandomValue random(5);
  for (const auto& effect : all_effects()) {
    for (int trial = 0; trial < 5; ++trial) {
      const SampleState s = random_state(random);
      const VectorXd none = VectorXd::Zero(effect->size());
      EXPECT_LT(effect->term(s, none).norm(), 1e-12) << effect->name();
      EXPECT_TRUE(jacobian(*effect, s, none).allFinite()) << effect->name();
    }
  }
}

TEST(Effects, that_drift_come_with_any_number_of_terms) {
  RandomValue random(6);
  const SampleState s = random_state(random);
  for (const char* name : {"gyro_bias_drift", "field_drift", "hard_iron_drift", "acc_bias_drift"}) {
    const auto few = find_effect(name)->with_terms(2), many = find_effect(name)->with_terms(5);
    EXPECT_EQ(few->size(), 6);
    EXPECT_EQ(many->size(), 15);
    EXPECT_EQ(few->name(), name);
    const MatrixXd J = jacobian(*many, s, VectorXd::Zero(15));
    EXPECT_EQ(jacobian(*few, s, VectorXd::Zero(6)), J.leftCols(6));
  }
  EXPECT_EQ(find_effect("lever_arm")->with_terms(2), nullptr);
}

// Half a minute from the time about which the sawtooth turns a tenth of a microsecond matters.
TEST(Effects, an_own_clock_has_the_jacobian_of_its_term_between_the_jumps_of_its_sawtooth) {
  RandomValue random(13);
  const auto effect = make_own_clock_at(0.01, 0.3, 30.0, 1e-6, 0.01);
  for (int trial = 0; trial < 20; ++trial) {
    SampleState s = random_state(random);
    s.t = 30.0 + 0.01 * (trial - 10.0 + 0.2);  // turns by half of one about 0.5
    const Eigen::Vector2d theta(1e-6, 1e-3);
    const MatrixXd J = jacobian(*effect, s, theta);
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d step = 1e-7 * Eigen::Vector2d::Unit(i);
      const Vector3 numerical =
          (effect->term(s, theta + step) - effect->term(s, theta - step)) / 2e-7;
      EXPECT_LT((J.col(i) - numerical).norm(), 1e-5 * std::max(1.0, J.norm())) << i;
    }
  }
}

TEST(Effects, an_own_clock_is_read_up_to_a_period_late) {
  SampleState s;
  s.D = Matrix3::Identity();
  s.field_before = [](double delay) -> Vector3 { return {delay, 0.0, 0.0}; };
  const auto clock = find_effect("mag_own_clock");
  for (int k = 0; k < 100; ++k) {
    s.t = 0.0035 * k;
    const double age = clock->term(s, Eigen::Vector2d(0.01, 0.25)).x();
    EXPECT_NEAR(age, std::fmod(s.t + 0.0025, 0.01), 1e-9);
  }
}

// A filter of first order turns the field's component across the rate by its phase.
TEST(Effects, a_lag_is_a_filter_of_first_order) {
  SampleState s;
  s.D = Matrix3::Identity();
  s.omega = Vector3(0, 0, 3.0);
  s.b = Vector3(1, 0, 0);
  s.field_before = [](double delay) -> Vector3 {
    return {std::cos(3.0 * delay), std::sin(3.0 * delay), 0.0};
  };
  for (const double tau : {0.01, 0.05}) {
    const double x = 3.0 * tau, gain = 1.0 / (1.0 + x * x);
    const Vector3 term = find_effect("mag_lag")->term(s, VectorXd::Constant(1, tau));
    EXPECT_LT((term - Vector3(gain - 1.0, gain * x, 0.0)).norm(), 1e-8) << tau;
  }
}

TEST(Effects, a_bias_walk_has_the_variance_of_a_random_walk) {
  const double q = 2e-4, T = 50.0;
  const auto walk = make_gyro_bias_walk(400, q);
  const VectorXd sigma = walk->prior_sigma(T);
  const auto variance_between = [&](double u0, double u1) {
    SampleState a, b;
    a.u = u0, b.u = u1;
    const VectorXd zero = VectorXd::Zero(walk->size());
    const MatrixXd D = jacobian(*walk, b, zero) - jacobian(*walk, a, zero);
    return (D * sigma.asDiagonal()).row(0).squaredNorm();
  };
  EXPECT_NEAR(variance_between(-1.0, 1.0) / (q * q * T), 1.0, 0.01);
  EXPECT_NEAR(variance_between(-0.4, 0.2) / (q * q * T), 0.3, 0.01);
}

TEST(Legendre, polynomials_are_orthogonal) {
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      double sum = 0.0;
      for (int k = 0; k < 20000; ++k) {
        const double u = (k + 0.5) / 10000.0 - 1.0;
        sum += legendre(i, u) * legendre(j, u) / 10000.0;
      }
      EXPECT_NEAR(sum, i == j ? 2.0 / (2 * i + 1) : 0.0, 1e-6);
    }
  }
}

// On the axis 2 k m / r^3 along the moment, beside it -k m / r^3; k = 0.1 uT m / A.
TEST(Dipole, field_has_its_two_known_strengths) {
  const Vector3 moment(0, 0, 2.0);
  EXPECT_LT((dipole_field(moment, {0, 0, 0.5}) - Vector3(0, 0, 3.2)).norm(), 1e-12);
  EXPECT_LT((dipole_field(moment, {0.5, 0, 0}) - Vector3(0, 0, -1.6)).norm(), 1e-12);
}

TEST(Effects, no_gravity_is_told_that_no_place_on_Earth_has) {
  const auto gravity = find_effect("gravity");
  const VectorXd sigma = VectorXd::Constant(1, 0.01);
  EXPECT_THAT(gravity->sentence(VectorXd::Constant(1, 0.05), sigma),
              testing::HasSubstr("Gravity here is more than the one assumed"));
  const std::string beyond = gravity->sentence(VectorXd::Constant(1, 0.118), sigma);
  EXPECT_THAT(beyond, testing::HasSubstr("All gains of the accelerometer are off alike"));
  EXPECT_THAT(beyond, testing::HasSubstr("1.20 % too much"));
}

// True seconds are longer than the file's: its clock is slow, and a gyroscope would read too
// little.
TEST(Effects, a_slow_clock_may_be_gains_of_the_gyroscope) {
  const auto clock = find_effect("clock_scale");
  const VectorXd sigma = VectorXd::Constant(1, 1e-4);
  const std::string slow = clock->sentence(VectorXd::Constant(1, 0.005), sigma);
  EXPECT_THAT(slow, testing::HasSubstr("runs too slowly by 0.500"));
  EXPECT_THAT(slow, testing::HasSubstr("reads too little"));
}

}  // namespace
}  // namespace magimu
