// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/rests/rests.h"

#include "sim/draws/random.h"
#include "sim/motions/hand_motion.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

// The rests of the simulated hand: between its stretches of movement.
std::vector<TimeSpan> true_rests(std::uint64_t seed, double duration_s) {
  const HandMotion hand(seed, duration_s, HandMotion::kRest);
  std::vector<TimeSpan> rests;
  double begin = 0.0;
  for (const Spline& stretch : hand.stretches()) {
    rests.push_back({begin, stretch.start});
    begin = stretch.end;
  }
  rests.push_back({begin, duration_s});
  return rests;
}

TEST(Rests, of_a_simulated_hand_are_found) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const Simulation s = test::simulated_hand(100.0, seed, HandMotion::kDuration);
    const std::vector<TimeSpan> found = find_rests(s.recording);
    const std::vector<TimeSpan> rests = true_rests(seed, HandMotion::kDuration);
    ASSERT_EQ(found.size(), rests.size()) << "seed " << seed;
    for (std::size_t i = 0; i < rests.size(); ++i) {
      // All within the true rest, and most of it.
      EXPECT_GT(found[i].begin_s, rests[i].begin_s - 0.05) << "seed " << seed << ", rest " << i;
      EXPECT_LT(found[i].end_s, rests[i].end_s + 0.05) << "seed " << seed << ", rest " << i;
      EXPECT_GT(found[i].length_s(), rests[i].length_s() - 1.1) << "seed " << seed << ", " << i;
    }
  }
}

TEST(Rests, tell_the_gyroscope_bias) {
  const Simulation s = test::simulated_hand(100.0, 2);
  const std::vector<TimeSpan> rests = find_rests(s.recording);
  const std::optional<Vector3> bias = gyr_bias_at_rest(s.recording, rests);
  ASSERT_TRUE(bias.has_value());
  double length = 0.0;
  for (const TimeSpan& rest : rests) length += rest.length_s();
  const double sigma = s.truth.noise.gyr / std::sqrt(length);
  EXPECT_LT((*bias - s.truth.parameters.gyr_bias).norm(), 5.0 * sigma);
}

TEST(Rests, tell_the_noise) {
  const Simulation s = test::simulated_hand(100.0, 2);
  const NoiseDensities noise = noise_at_rest(s.recording, find_rests(s.recording));
  EXPECT_NEAR(noise.acc / s.truth.noise.acc, 1.0, 0.1);
  EXPECT_NEAR(noise.gyr / s.truth.noise.gyr, 1.0, 0.1);
  EXPECT_NEAR(noise.mag / s.truth.noise.mag, 1.0, 0.1);
}

// In a hand, or on something that shakes, the accelerometer is noisier than any part is.
TEST(Rests, of_a_trembling_hand_tell_no_noise) {
  const Simulation s = test::simulated_hand(100.0, 2);
  const std::vector<TimeSpan> rests = find_rests(s.recording);
  ASSERT_GT(rests.size(), 2U);
  EXPECT_EQ(quiet_rests(s.recording, rests).size(), rests.size());
  const auto shaken = [&](const TimeSpan& rest, bool coloured = true) {
    Recording r = s.recording;
    RandomStream random(5, RandomPurpose::kMotion);
    Vector3 tremor = Vector3::Zero();
    for (std::size_t k = 0; k < r.acc.size(); ++k) {
      const Vector3 jolt = 0.05 * std::sqrt(r.acc.rate_hz()) * random.normal3();
      tremor = coloured ? Vector3(0.6 * tremor + 0.8 * jolt) : jolt;
      if (r.acc.t[k] < rest.begin_s || r.acc.t[k] > rest.end_s) continue;
      r.acc.v[k] += tremor;
    }
    return r;
  };
  const Recording one = shaken(rests.front());
  EXPECT_EQ(quiet_rests(one, rests).size(), rests.size() - 1);
  const NoiseDensities noise = noise_at_rest(one, rests);
  EXPECT_NEAR(noise.acc / s.truth.noise.acc, 1.0, 0.1);
  EXPECT_NEAR(noise.gyr / s.truth.noise.gyr, 1.0, 0.1);
  const NoiseDensities none = noise_at_rest(shaken({-1.0, 1e3}), rests);
  EXPECT_EQ(none.acc, 0.0);
  EXPECT_EQ(none.gyr, 0.0);
  EXPECT_GT(none.mag, 0.0);
  // White noise is noise, however much of it there is.
  EXPECT_GT(noise_at_rest(shaken({-1.0, 1e3}, false), rests).acc, 0.05);
}

TEST(Rests, a_steady_turn_is_none) {
  Recording r;
  for (int k = 0; k < 1000; ++k) {
    r.gyr.push_back(0.01 * k, Vector3(0.0, 0.0, 0.5));
    r.acc.push_back(0.01 * k, Vector3(0.0, 0.0, 9.8));
  }
  EXPECT_TRUE(find_rests(r).empty());
  for (Vector3& rate : r.gyr.v) rate *= 0.1;  // slow enough to be a bias
  EXPECT_EQ(find_rests(r).size(), 1U);
}

TEST(Rests, where_there_are_none_nothing_is_told) {
  const Simulation s = test::simulated_paper(50.0);
  const std::vector<TimeSpan> rests = find_rests(s.recording);
  EXPECT_TRUE(rests.empty());
  EXPECT_FALSE(gyr_bias_at_rest(s.recording, rests).has_value());
  const NoiseDensities noise = noise_at_rest(s.recording, rests);
  EXPECT_EQ(noise.acc, 0.0);
  EXPECT_EQ(noise.gyr, 0.0);
  EXPECT_EQ(noise.mag, 0.0);
}

TEST(Rests, a_recording_without_samples_has_none) { EXPECT_TRUE(find_rests(Recording{}).empty()); }

TEST(Rests, are_not_needed_to_tell_the_noise_at_the_least) {
  for (const double rate : {20.0, 80.0, 200.0}) {
    const Simulation s = test::simulated_hand(rate, 3, 60.0);
    const HandMotion hand(3, 60.0, HandMotion::kRest);
    const Spline& stretch = hand.stretches().front();
    Recording moving = slice(s.recording, stretch.start, stretch.end);
    EXPECT_TRUE(find_rests(moving).empty());
    const NoiseDensities& truth = s.truth.noise;
    EXPECT_NEAR(least_noise(moving.acc) / truth.acc, 0.9, 0.12) << rate;
    EXPECT_NEAR(least_noise(moving.gyr) / truth.gyr, 0.9, 0.12) << rate;
    moving.gyr.v.resize(12);
    moving.gyr.t.resize(12);
    EXPECT_EQ(least_noise(moving.gyr), 0.0);
  }
}

}  // namespace
}  // namespace magimu
