// SPDX-License-Identifier: BSD-3-Clause
// For tests: what effects add to the exact recording of a hand, compared with an equation written
// out once more from the motion.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "tests/oracle/sensors.h"

namespace magimu::oracle {

inline Options exact(MotionKind kind = MotionKind::kHandHeld) {
  Options options;
  options.seed = 4;
  options.motion.kind = kind;
  options.motion.duration_s = 30.0;
  options.noise_factor = 0.0;
  return options;
}

inline Simulation with(Options options, std::vector<Effect> effects) {
  options.effects = std::move(effects);
  return simulate(options);
}

// What effects do to the exact recording of a hand.
struct Comparison {
  explicit Comparison(const Effect& effect, Options options = exact())
      : motion(options.motion, options.seed),
        before(simulate(options)),
        after(with(options, {effect})),
        device(before.truth.device) {}

  Matrix3d bRn(double t) const { return motion.nRb(t).conjugate().toRotationMatrix(); }
  Vector3d b(double t) const { return bRn(t) * device.unit_field(); }
  Vector3d f(double t) const { return bRn(t) * (motion.acceleration(t) + Vector3d(0, 0, 9.80665)); }

  // after = before + expected(t), and nothing else changed; gyroscope: in the mean over intervals.
  using Function = std::function<Vector3d(double)>;
  void only_acc(const Function& expected, double tolerance = 1e-11) const {
    expect(before.recording.acc, after.recording.acc, expected, tolerance);
    EXPECT_EQ(before.recording.gyr.v, after.recording.gyr.v);
    EXPECT_EQ(before.recording.mag[0].v, after.recording.mag[0].v);
  }
  void only_mag(const Function& expected, double tolerance = 1e-10) const {
    expect(before.recording.mag[0], after.recording.mag[0], expected, tolerance);
    EXPECT_EQ(before.recording.gyr.v, after.recording.gyr.v);
    EXPECT_EQ(before.recording.acc.v, after.recording.acc.v);
  }
  void only_gyr(const Function& expected, double tolerance = 1e-9) const {
    const auto mean = [&](double t) -> Vector3d {
      Vector3d sum = Vector3d::Zero();
      for (int i = 0; i < 20; ++i) sum += expected(t + 0.01 * (i + 0.5) / 20) / 20.0;
      return sum;
    };
    expect(before.recording.gyr, after.recording.gyr, mean, tolerance);
    EXPECT_EQ(before.recording.acc.v, after.recording.acc.v);
    EXPECT_EQ(before.recording.mag[0].v, after.recording.mag[0].v);
  }
  static void expect(const VectorSeries& a, const VectorSeries& b, const Function& expected,
                     double tolerance) {
    double worst = 0.0, largest = 0.0;
    for (std::size_t k = 0; k < a.size(); k += 3) {
      const Vector3d difference = b.v[k] - a.v[k];
      largest = std::max(largest, difference.norm());
      worst = std::max(worst, (difference - expected(a.t[k])).norm());
    }
    EXPECT_LT(worst, tolerance);
    EXPECT_GT(largest, 1e3 * tolerance);
  }

  Motion motion;
  Simulation before, after;
  Device device;
};

// The mean over the recording's samples.
template <class F>
auto mean_over_samples(const Comparison& c, F&& f) {
  auto sum = f(0.0);
  for (std::size_t k = 1; k < c.before.truth.t.size(); ++k) sum += f(c.before.truth.t[k]);
  return decltype(sum)(sum / static_cast<double>(c.before.truth.t.size()));
}

}  // namespace magimu::oracle
