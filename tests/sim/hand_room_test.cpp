// SPDX-License-Identifier: BSD-3-Clause
// A room about a sensor in the hand: its field could be in empty space, reaches the magnetometer
// alone, and is refused where the sensor stays in its place.
#include "sim/hand_room.h"

#include <gtest/gtest.h>

#include "recording/data/error.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

SimulationOptions exact_hand() {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHandHeld;
  options.noise_factor = 0.0;
  options.duration_s = 40.0;
  options.mag_ratio = 2;
  return options;
}

TEST(HandRoom, has_a_field_without_divergence_and_curl_that_differs_from_place_to_place) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const HandRoom room(seed, Vector3(0.0, 0.3, -0.95), 100.0);
    const Vector3 at(0.1, -0.1, 0.05);
    Matrix3 gradient;
    for (int i = 0; i < 3; ++i) {
      const Vector3 h = 1e-4 * Vector3::Unit(i);
      gradient.col(i) = (room.field_uT(at + h, 50.0) - room.field_uT(at - h, 50.0)) / 2e-4;
    }
    EXPECT_GT(gradient.norm(), 0.2) << seed;  // uT/m
    EXPECT_LT(gradient.norm(), 50.0) << seed;
    EXPECT_LT(std::abs(gradient.trace()), 1e-5 * gradient.norm()) << seed;
    EXPECT_LT((gradient - gradient.transpose()).norm(), 1e-5 * gradient.norm()) << seed;
  }
}

TEST(HandRoom, has_a_tram_that_passes_once) {
  const HandRoom room(4, Vector3(0.0, 0.3, -0.95), 100.0);
  const Vector3 without = room.field_uT(Vector3::Zero(), -1e6);
  const double passing = (room.field_uT(Vector3::Zero(), room.tram_passes_s()) - without).norm();
  const double before =
      (room.field_uT(Vector3::Zero(), room.tram_passes_s() - 25.0) - without).norm();
  EXPECT_GT(passing, 0.001);
  EXPECT_LT(before, 0.05 * passing);
}

TEST(HandRoom, reaches_the_magnetometer_alone_and_turns_with_the_sensor) {
  SimulationOptions options = exact_hand();
  const Simulation before = simulate(options);
  options.room = 3;
  const Simulation after = simulate(options);
  EXPECT_EQ(before.recording.acc.v, after.recording.acc.v);
  EXPECT_EQ(before.recording.gyr.v, after.recording.gyr.v);
  const SensorParameters& p = before.truth.parameters;
  const HandRoom room(3, unit_field(p.dip_rad), before.truth.t.back());
  for (std::size_t k = 0; k < before.recording.mag[0].size(); k += 11) {
    const std::size_t i = 2 * k;
    const Vector3 field = room.field_uT(before.truth.p[i], before.truth.t[i]);
    const Vector3 expected =
        p.mag[0].distortion * before.truth.nRb[i].unrotate(field) / before.truth.strength_uT;
    const Vector3 change = after.recording.mag[0].v[k] - before.recording.mag[0].v[k];
    EXPECT_LT((change - expected).norm(), 1e-9);
    EXPECT_GT(change.norm(), 1e-3);
  }
}

TEST(HandRoom, is_refused_where_the_sensor_only_turns) {
  SimulationOptions options = exact_hand();
  options.motion = SimulatedMotion::kHand;
  options.room = 1;
  EXPECT_THROW(simulate(options), InputError);
}

}  // namespace
}  // namespace magimu
