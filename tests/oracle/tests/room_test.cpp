// SPDX-License-Identifier: BSD-3-Clause
// The room's field is one that can be in empty space, differs by microteslas over a hand's reach,
// and reaches the magnetometer alone, turned with the sensor.
#include "tests/oracle/room.h"

#include "tests/oracle/tests/comparison.h"

namespace magimu::oracle {
namespace {

TEST(Room, has_a_field_without_divergence_and_curl) {
  const Room room(3, Vector3d(0.0, 0.4, -0.9), 100.0);
  const Vector3d at(0.1, -0.2, 0.05);
  Matrix3d gradient;
  for (int i = 0; i < 3; ++i) {
    const Vector3d h = 1e-4 * Vector3d::Unit(i);
    gradient.col(i) = (room.field_uT(at + h, 50.0) - room.field_uT(at - h, 50.0)) / 2e-4;
  }
  EXPECT_GT(gradient.norm(), 0.1);
  EXPECT_LT(std::abs(gradient.trace()), 1e-5 * gradient.norm());
  EXPECT_LT((gradient - gradient.transpose()).norm(), 1e-5 * gradient.norm());
}

TEST(Room, differs_by_microteslas_within_a_hands_reach_and_when_the_tram_passes) {
  int trams = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Room room(seed, Vector3d(0.0, 0.4, -0.9), 100.0);
    const double step =
        (room.field_uT({0.3, 0, -0.1}, 0.0) - room.field_uT({-0.3, 0, 0.1}, 0.0)).norm();
    EXPECT_GT(step, 0.05) << seed;
    EXPECT_LT(step, 30.0) << seed;
    double most = 0.0;
    for (double t = 0.0; t < 100.0; t += 0.5) {
      most = std::max(most, (room.field_uT({0, 0, 0}, t) - room.field_uT({0, 0, 0}, -1e5)).norm());
    }
    trams += most > 0.01 && most < 3.0;
  }
  EXPECT_GE(trams, 15);
}

TEST(Room, reaches_the_magnetometer_and_turns_with_it) {
  Options options = exact();
  const Simulation before = simulate(options);
  options.room_seed = 5;
  const Simulation after = simulate(options);
  const Motion motion(options.motion, options.seed);
  const Device& device = before.truth.device;
  const Room room(5, device.unit_field(), options.motion.duration_s);
  EXPECT_EQ(before.recording.gyr.v, after.recording.gyr.v);
  EXPECT_EQ(before.recording.acc.v, after.recording.acc.v);
  double largest = 0.0;
  for (std::size_t k = 0; k < before.recording.mag[0].size(); k += 7) {
    const double t = before.recording.mag[0].t[k];
    const Vector3d expected = device.distortion *
                              (motion.nRb(t).conjugate() * room.field_uT(motion.position(t), t)) /
                              device.strength_uT();
    const Vector3d change = after.recording.mag[0].v[k] - before.recording.mag[0].v[k];
    EXPECT_LT((change - expected).norm(), 1e-9);
    largest = std::max(largest, change.norm());
  }
  EXPECT_GT(largest, 0.05);
}

}  // namespace
}  // namespace magimu::oracle
