// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/checks/sensor_changes.h"

#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "bench/streamed.h"
#include "graph/bytes.h"

namespace magimu {
namespace {

constexpr int kNode = 3, kBiases = 3;
constexpr double kSigma = 0.01;

// A chain whose nodes are measured exactly, and windows that measure the biases of three sensors
// with sigma 0.01; what is known of them before is known to 0.001.
class Windows {
 public:
  explicit Windows(unsigned seed) : random_(seed) {}

  // biases: of all sensors, in this window, in sigmas.
  void add(SensorChanges& to, const VectorXd& biases) {
    Stretch s;
    const int n = kNode + 3 * kBiases;
    s.before = {kNode, 0, 3 * kBiases, RowBlock::Zero(n, n + 1), 0.0};
    s.before.R.leftCols(n).diagonal().setConstant(10.0 / kSigma);
    const int w = 2 * kNode + 3 * kBiases;
    s.own = {kNode, kNode, 3 * kBiases, RowBlock::Zero(w, w + 1), 0.0};
    s.own.R.leftCols(w).diagonal().setConstant(1.0 / kSigma);
    for (int i = 0; i < 3 * kBiases; ++i) {
      const double y = biases[i] + std::sqrt(1.0 + 0.01) * normal_(random_);
      s.own.R(2 * kNode + i, w) = -y;
    }
    to.add(s, {{0, 3}, {3, 3}, {6, 3}}, t_, t_ + 1.0);
    t_ += 1.0;
  }
  double t() const { return t_; }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  double t_ = 0.0;
};

VectorXd none() { return VectorXd::Zero(3 * kBiases); }
VectorXd of_sensor(int sensor, const Vector3& bias) {
  VectorXd out = none();
  out.segment<3>(3 * sensor) = bias;
  return out;
}

// Doob: at most 90 / 100 / 100 of streams of 90 windows; of 100 that are at most 4 at 99 %.
TEST(SensorChanges, white_noise_is_as_before) {
  int told = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    Windows windows(seed);
    SensorChanges changes;
    bool ever = false;
    for (int k = 0; k < 90; ++k) {
      windows.add(changes, none());
      ever = ever || changes.likeliest().is_told();
    }
    told += ever ? 1 : 0;
  }
  EXPECT_LE(told, 4);
}

TEST(SensorChanges, a_step_is_told_with_its_sensor_time_and_size) {
  for (const int sensor : {0, 1, 2}) {
    Windows windows(unsigned(10 + sensor));
    SensorChanges changes;
    for (int k = 0; k < 40; ++k) windows.add(changes, none());
    EXPECT_FALSE(changes.likeliest().is_told());
    const Vector3 step(2.0, -1.0, 1.0);
    double told_s = 0.0;
    for (int k = 0; k < 30; ++k) {
      windows.add(changes, of_sensor(sensor, step));
      if (told_s == 0.0 && changes.likeliest().is_told()) told_s = windows.t();
    }
    // Three nats a window.
    EXPECT_GT(told_s, 40.0);
    EXPECT_LT(told_s, 50.0);
    const SensorChange d = changes.likeliest();
    EXPECT_EQ(d.sensor, sensor);
    EXPECT_TRUE(d.also_likely.empty());
    EXPECT_TRUE(d.stays);
    EXPECT_LE(d.earliest_s, 41.0);
    EXPECT_GE(d.latest_s, 40.0);
    EXPECT_LT((d.size / kSigma - step).norm(), 1.5);
  }
}

// As a gain that changes while the sensor turns.
TEST(SensorChanges, what_changes_its_sign_is_told_and_does_not_stay) {
  Windows windows(3);
  SensorChanges changes;
  for (int k = 0; k < 40; ++k) windows.add(changes, none());
  for (int k = 0; k < 16; ++k) {
    const double sign = k % 2 == 0 ? 1.0 : -1.0;
    windows.add(changes, of_sensor(1, sign * Vector3(4.0, -3.0, 3.0)));
  }
  const SensorChange d = changes.likeliest();
  EXPECT_TRUE(d.is_told());
  EXPECT_EQ(d.sensor, 1);
  EXPECT_FALSE(d.stays);
}

TEST(SensorChanges, one_wild_window_is_no_change) {
  Windows windows(4);
  SensorChanges changes;
  for (int k = 0; k < 40; ++k) windows.add(changes, none());
  windows.add(changes, of_sensor(0, Vector3(500.0, 0.0, 0.0)));
  EXPECT_FALSE(changes.likeliest().is_told());
  for (int k = 0; k < 10; ++k) {
    windows.add(changes, none());
    EXPECT_FALSE(changes.likeliest().is_told());
  }
}

// Errors that were as large from the first window on are as before.
TEST(SensorChanges, what_has_been_so_all_the_time_is_as_before) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Windows windows(5);
  SensorChanges changes;
  for (int k = 0; k < 90; ++k) {
    VectorXd biases = none();
    for (double& b : biases) b = 4.0 * normal(random);
    windows.add(changes, biases);
    EXPECT_FALSE(changes.likeliest().is_told()) << k;
  }
}

TEST(SensorChanges, what_was_saved_goes_on_with_the_same_bits) {
  Windows windows(6), same(6);
  SensorChanges changes, again;
  for (int k = 0; k < 37; ++k) windows.add(changes, none()), same.add(again, none());
  std::stringstream file;
  ByteWriter out(file);
  changes.save(out);
  ASSERT_TRUE(out.finish());
  SensorChanges restored;
  ByteReader in(file);
  restored.load(in);
  for (int k = 0; k < 30; ++k) {
    windows.add(restored, of_sensor(2, {1.0, 1.0, 0.0}));
    same.add(again, of_sensor(2, {1.0, 1.0, 0.0}));
    EXPECT_EQ(restored.likeliest().log_odds, again.likeliest().log_odds);
  }
}

// Through the program's stream: a step of the gyroscope is told, not a magnet.
TEST(SensorChanges, of_a_stream) {
  SimulationOptions simulation;
  simulation.motion = SimulatedMotion::kHandHeld;
  simulation.seed = 77;
  simulation.duration_s = 80.0;
  const Simulation s = simulate(simulation);
  for (const bool steps : {false, true}) {
    Recording r = s.recording;
    for (std::size_t k = 0; steps && k < r.gyr.size(); ++k) {
      if (r.gyr.t[k] > 40.0) r.gyr.v[k] += Vector3(0.004, -0.003, 0.002);
    }
    StreamingOptions options;
    options.gravity = s.truth.gravity;
    options.motion = MotionModel::kHandHeld;
    StreamingCalibration stream(1, options);
    std::optional<SensorChange> first;
    double told_s = 0.0;
    bool in_checks = false;
    std::string said;
    for (const StreamSample& sample : samples_of(r)) {
      const auto u = stream.add(sample);
      if (!u) continue;
      for (const std::string& e : u->events) said += e + "\n";
      for (const Check& c : u->checks) in_checks = in_checks || c.name == "sensor_change";
      if (!first && u->sensor_change) {
        first = u->sensor_change;
        told_s = u->t;
      }
    }
    ASSERT_EQ(first.has_value(), steps) << said;
    EXPECT_EQ(in_checks, steps);
    if (!steps) continue;
    EXPECT_EQ(first->sensor, 1) << said;
    EXPECT_GT(told_s, 40.0);
    EXPECT_LT(told_s, 52.0);
    EXPECT_NEAR(first->since_s, 40.0, 4.0);
    EXPECT_NE(said.find("the gyroscope reads otherwise"), std::string::npos) << said;
    EXPECT_EQ(said.find("attached or removed"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace magimu
