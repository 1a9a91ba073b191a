// SPDX-License-Identifier: BSD-3-Clause
// Coupling between the magnetometers of an array: found where it is hidden, and not where something
// else is that they have in common.
#include "diagnosis/conclude/array_coupling.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/pipeline.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

constexpr double kCouplingLevel = 0.01;

Simulation array_with(const std::vector<std::string>& effects, std::uint64_t seed = 4,
                      int magnetometers = 5) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 100.0;
  options.seed = seed;
  options.gravity = kStandardGravity;
  options.magnetometers = magnetometers;
  for (const std::string& e : effects) options.effects.push_back(parse_effect_request(e));
  return simulate(options);
}

CouplingSearch search_in(const Simulation& s) {
  CalibrationOptions options;
  options.motion = MotionModel::kRotation;
  options.mag_time_offset = false;
  const CheckedRecordings checked({&s.recording});
  const Pipeline pipeline(checked.get(), options);
  std::string why;
  return find_coupling(pipeline.fine(pipeline.coarse(why)), kCouplingLevel);
}

// The same by hand, of a simulation without it.
TEST(ArrayCoupling, adds_what_the_neighbours_read_by_themselves) {
  const Simulation without = array_with({}, 4, 3),
                   with = array_with({"mag_coupling=1:2:3:4:5:6:7:8:9"}, 4, 3);
  const auto &a = without.recording.mag, &b = with.recording.mag;
  for (std::size_t k = 0; k < a[0].size(); k += 500) {
    const Vector3 x = a[0].v[k], y = a[1].v[k], z = a[2].v[k];
    const auto times = [](const Vector3& v) {
      return Vector3(1 * v.x() + 2 * v.y() + 3 * v.z(), 4 * v.x() + 5 * v.y() + 6 * v.z(),
                     7 * v.x() + 8 * v.y() + 9 * v.z());
    };
    const auto turned = [](const Vector3& v) {
      return Vector3(1 * v.x() + 4 * v.y() + 7 * v.z(), 2 * v.x() + 5 * v.y() + 8 * v.z(),
                     3 * v.x() + 6 * v.y() + 9 * v.z());
    };
    EXPECT_LT((b[0].v[k] - x - times(y)).norm(), 1e-9);
    EXPECT_LT((b[1].v[k] - y - times(z) - turned(x)).norm(), 1e-9);
    EXPECT_LT((b[2].v[k] - z - turned(y)).norm(), 1e-9);
  }
}

TEST(ArrayCoupling, is_found_between_neighbours_with_its_size) {
  // Its size is 12 sigma: at half of it every other row of neighbours misses a pair.
  const Simulation s = array_with({"mag_coupling=0.04:0:0.02:-0.03:0.06:0:0:0.02:-0.04"});
  const CouplingSearch found = search_in(s);
  EXPECT_FALSE(found.common);
  EXPECT_EQ(found.tested, 10);
  ASSERT_EQ(found.pairs.size(), 4u);
  Matrix3 C;
  C << 0.04, 0.0, 0.02, -0.03, 0.06, 0.0, 0.0, 0.02, -0.04;
  double squares = 0.0;
  for (const CoupledPair& p : found.pairs) {
    EXPECT_EQ(p.second, p.first + 1);
    // First order in C: the densities of the readings have C's square in them.
    EXPECT_LT((p.C - C).cwiseAbs().maxCoeff(), 4.0 * p.sigma);
    EXPECT_LT(p.nll_after, 0.0);
    squares += (p.C - C).squaredNorm() / (p.sigma * p.sigma);
  }
  EXPECT_LT(squares, 69.0);  // 0.1 % of chi-square with 36
  EXPECT_GT(squares, 12.0);
}

// Neighbours that are too weak to be named are no cause that all have in common.
TEST(ArrayCoupling, of_half_that_size_is_found_in_some_pairs_and_called_coupling) {
  for (const std::uint64_t seed : {4U, 5U, 6U}) {
    const CouplingSearch found =
        search_in(array_with({"mag_coupling=0.02:0:0.01:-0.015:0.03:0:0:0.01:-0.02"}, seed));
    EXPECT_FALSE(found.common) << seed;
    EXPECT_GE(found.pairs.size(), 1u) << seed;
    for (const CoupledPair& p : found.pairs) EXPECT_EQ(p.second, p.first + 1) << seed;
  }
}

TEST(ArrayCoupling, is_not_found_where_there_is_none) {
  int named = 0;
  double squares = 0.0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    const CouplingSearch found = search_in(array_with({}, seed));
    named += found.pairs.empty() ? 0 : 1;
    squares += found.strongest.statistic;
  }
  EXPECT_EQ(named, 0);
  // The largest of ten chi-square variables with 9 degrees of freedom: 17.4 on the average, with a
  // standard deviation of 4.2.
  EXPECT_NEAR(squares / 6.0, 17.4, 3.0 * 4.2 / std::sqrt(6.0));
}

// What shows in all magnetometers alike, and what shows in the noise of each.
TEST(ArrayCoupling, is_not_named_for_its_neighbours) {
  for (const char* other :
       {"mag_eddy_current=3", "mag_time_offset=2", "mains_interference", "correlated_noise@mag",
        "gyro_scale_misalignment", "field_drift=2", "correlated_noise@gyr", "noise_scale@gyr=2:"}) {
    const CouplingSearch found = search_in(array_with({other}));
    EXPECT_TRUE(found.pairs.empty() || found.common) << other;
  }
}

TEST(ArrayCoupling, becomes_a_finding_of_the_diagnosis) {
  const Simulation s = array_with({"mag_coupling=0.03:0:0.01:-0.015:0.04:0:0:0.01:-0.03"}, 6, 4);
  const Diagnosis d = diagnose(s.recording);
  ASSERT_EQ(d.findings.size(), 1u);
  EXPECT_EQ(d.findings.front().effect, "mag_coupling");
  EXPECT_EQ(d.findings.front().parameters.size(), 27u);
  EXPECT_EQ(d.answer, Answer::kExplained);
  EXPECT_THAT(d.findings.front().sentence, testing::HasSubstr("mag"));
}

TEST(ArrayCoupling, is_no_question_of_a_single_magnetometer) {
  const Diagnosis d = diagnose(array_with({}, 2, 1).recording);
  for (const ScanEntry& e : d.scan) EXPECT_NE(e.effect, "mag_coupling");
}

}  // namespace
}  // namespace magimu
