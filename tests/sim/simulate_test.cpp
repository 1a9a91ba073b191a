// SPDX-License-Identifier: BSD-3-Clause
// Simulated recordings against the equations of docs/theory.md, written out here with rotation
// matrices of the test's own, so that a slip in the models themselves would show.
#include "sim/simulate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "recording/data/error.h"
#include "sim/truth_json.h"

namespace magimu {
namespace {

using Array3 = std::array<double, 3>;
using Array33 = std::array<Array3, 3>;

SimulationOptions short_options(SimulatedMotion motion, double noise_factor) {
  SimulationOptions options;
  options.motion = motion;
  options.duration_s = 30.0;
  options.noise_factor = noise_factor;
  options.magnetometers = 2;
  return options;
}

// The matrix of a unit quaternion (w, x, y, z), which turns vectors of the sensor into n.
Array33 matrix_of(const Rot3& R) {
  const double w = R.quaternion()[0], x = R.quaternion()[1], y = R.quaternion()[2],
               z = R.quaternion()[3];
  return {{{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}}};
}

Array3 transposed_times(const Array33& m, const Array3& v) {
  Array3 r{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) r[i] += m[j][i] * v[j];
  }
  return r;
}

// Rodrigues' formula.
Matrix3 exponential(const Vector3& v) {
  const double a = v.norm();
  if (a == 0.0) return Matrix3::Identity();
  Matrix3 K;
  K << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  K /= a;
  return Matrix3::Identity() + std::sin(a) * K + (1 - std::cos(a)) * K * K;
}

void expect_same_bits(const VectorSeries& a, const VectorSeries& b) {
  EXPECT_EQ(a.t, b.t);
  EXPECT_EQ(a.v, b.v);
}

class EveryMotion : public testing::TestWithParam<SimulatedMotion> {};
INSTANTIATE_TEST_SUITE_P(Simulate, EveryMotion,
                         testing::Values(SimulatedMotion::kPaper, SimulatedMotion::kHand,
                                         SimulatedMotion::kHandHeld, SimulatedMotion::kSequence),
                         [](const auto& motion) { return to_string(motion.param); });

TEST_P(EveryMotion, same_seed_gives_the_same_bits) {
  const Simulation a = simulate(short_options(GetParam(), 1.0));
  const Simulation b = simulate(short_options(GetParam(), 1.0));
  expect_same_bits(a.recording.acc, b.recording.acc);
  expect_same_bits(a.recording.gyr, b.recording.gyr);
  for (std::size_t i = 0; i < 2; ++i) expect_same_bits(a.recording.mag[i], b.recording.mag[i]);
}

TEST_P(EveryMotion, different_seeds_give_different_data) {
  SimulationOptions options = short_options(GetParam(), 1.0);
  const Simulation a = simulate(options);
  options.seed = 2;
  const Simulation b = simulate(options);
  EXPECT_NE(a.truth.parameters.acc_bias, b.truth.parameters.acc_bias);
  EXPECT_NE(a.truth.nRb.back().quaternion(), b.truth.nRb.back().quaternion());
  for (std::size_t k = 0; k < a.truth.t.size(); ++k) {
    EXPECT_NE(a.recording.acc.v[k], b.recording.acc.v[k]);
    EXPECT_NE(a.recording.gyr.v[k], b.recording.gyr.v[k]);
  }
}

// acc = -R' g + o_a with g = (0, 0, -g0); mag = D R' m + o_m with m = (0, cos alpha, -sin alpha).
TEST_P(EveryMotion, exact_measurements_obey_the_models) {
  SimulationOptions options = short_options(GetParam(), 0.0);
  options.displacement_m = 0.0;
  const Simulation s = simulate(options);
  const SensorParameters& p = s.truth.parameters;
  ASSERT_EQ(s.recording.acc.size(), 2400u);
  ASSERT_EQ(s.recording.mag.size(), 2u);
  for (std::size_t k = 0; k < s.truth.t.size(); ++k) {
    EXPECT_EQ(s.recording.acc.t[k], static_cast<double>(k) / 80.0);
    const Array33 R = matrix_of(s.truth.nRb[k]);
    const Array3 g = transposed_times(R, {0.0, 0.0, -9.8});
    const Array3 b = transposed_times(R, {0.0, std::cos(p.dip_rad), -std::sin(p.dip_rad)});
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(s.recording.acc.v[k][i], -g[static_cast<std::size_t>(i)] + p.acc_bias[i], 1e-11);
      for (std::size_t j = 0; j < 2; ++j) {
        const Matrix3& D = p.mag[j].distortion;
        const double expected = D(i, 0) * b[0] + D(i, 1) * b[1] + D(i, 2) * b[2] + p.mag[j].bias[i];
        EXPECT_NEAR(s.recording.mag[j].v[k][i], expected, 1e-10);
      }
    }
  }
}

TEST_P(EveryMotion, integrating_the_exact_gyroscope_gives_the_attitude) {
  const Simulation s = simulate(short_options(GetParam(), 0.0));
  Matrix3 R = s.truth.nRb.front().matrix();
  for (std::size_t k = 0; k < s.truth.t.size(); ++k) {
    ASSERT_LT((s.truth.nRb[k].matrix() - R).norm(), 1e-10);
    R = R * exponential((s.recording.gyr.v[k] - s.truth.parameters.gyr_bias) / 80.0);
  }
}

TEST_P(EveryMotion, noise_of_a_sample_is_the_density_times_the_root_of_the_rate) {
  SimulationOptions options = short_options(GetParam(), 1.0);
  options.duration_s = 120.0;
  options.mag_ratio = 2;
  const Simulation noisy = simulate(options);
  options.noise_factor = 0.0;
  const Simulation exact = simulate(options);
  const auto expect_sigma = [](const VectorSeries& a, const VectorSeries& b, double sigma) {
    const double n = static_cast<double>(a.size());
    Vector3 sum = Vector3::Zero(), squares = Vector3::Zero();
    for (std::size_t k = 0; k < a.size(); ++k) {
      sum += a.v[k] - b.v[k];
      squares += (a.v[k] - b.v[k]).cwiseAbs2();
    }
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(sum[i] / n, 0.0, 4.5 * sigma / std::sqrt(n));
      EXPECT_NEAR(std::sqrt(squares[i] / n), sigma, 4.5 * sigma / std::sqrt(2 * n));
    }
  };
  expect_sigma(noisy.recording.acc, exact.recording.acc, 0.02 * std::sqrt(80.0));
  expect_sigma(noisy.recording.gyr, exact.recording.gyr, 8.7266e-4 * std::sqrt(80.0));
  for (std::size_t i = 0; i < 2; ++i) {
    expect_sigma(noisy.recording.mag[i], exact.recording.mag[i], 0.003 * std::sqrt(40.0));
  }
  EXPECT_NE(noisy.recording.mag[0].v[0] - exact.recording.mag[0].v[0],
            noisy.recording.mag[1].v[0] - exact.recording.mag[1].v[0]);
}

TEST_P(EveryMotion, a_slower_magnetometer_has_every_nth_sample_and_the_imu_all_its_own) {
  SimulationOptions options = short_options(GetParam(), 0.0);
  const Recording full = simulate(options).recording;
  options.mag_ratio = 7;
  const Recording slow = simulate(options).recording;
  expect_same_bits(full.acc, slow.acc);
  expect_same_bits(full.gyr, slow.gyr);
  ASSERT_EQ(slow.mag[0].size(), (full.mag[0].size() + 6) / 7);
  for (std::size_t k = 0; k < slow.mag[0].size(); ++k) {
    EXPECT_EQ(slow.mag[0].t[k], full.mag[0].t[7 * k]);
    EXPECT_EQ(slow.mag[0].v[k], full.mag[0].v[7 * k]);
  }
}

TEST_P(EveryMotion, one_more_magnetometer_changes_nothing_else) {
  SimulationOptions options = short_options(GetParam(), 1.0);
  const Recording two = simulate(options).recording;
  options.magnetometers = 1;
  const Recording one = simulate(options).recording;
  expect_same_bits(one.acc, two.acc);
  expect_same_bits(one.gyr, two.gyr);
  expect_same_bits(one.mag[0], two.mag[0]);
  EXPECT_EQ(one.mag_names, std::vector<std::string>{"mag"});
  EXPECT_EQ(two.mag_names, (std::vector<std::string>{"mag1", "mag2"}));
}

TEST(Simulate, by_default_makes_the_data_set_of_the_paper) {
  const Simulation s = simulate({});
  EXPECT_EQ(s.recording.acc.size(), 25743u);  // 321.78 s at 80 Hz
  EXPECT_EQ(s.recording.gyr.size(), 25743u);
  EXPECT_EQ(s.recording.mag.at(0).size(), 25743u);
  EXPECT_EQ(s.truth.nRb.size(), 25743u);
  EXPECT_EQ(s.truth.gravity, 9.8);
  EXPECT_EQ(s.truth.noise.acc, 0.02);
  EXPECT_NEAR(s.truth.noise.gyr, 0.00087, 5e-6);
  EXPECT_EQ(s.truth.noise.mag, 0.003);
  EXPECT_TRUE(s.truth.p.empty());
  ASSERT_TRUE(s.recording.truth.has_value());
  EXPECT_EQ(s.recording.truth->t, s.truth.t);
}

TEST(Simulate, a_hand_takes_two_minutes_and_reads_only_the_bias_while_it_rests) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.noise_factor = 0.0;
  const Simulation s = simulate(options);
  ASSERT_EQ(s.recording.gyr.size(), 9600u);
  for (std::size_t k = 0; k < 240; ++k) {
    EXPECT_EQ(s.recording.gyr.v[k], s.truth.parameters.gyr_bias);
    EXPECT_EQ(s.recording.gyr.v[9599 - k], s.truth.parameters.gyr_bias);
  }
}

TEST(Simulate, a_hand_moves_the_same_way_at_80_and_160_hertz) {
  SimulationOptions options = short_options(SimulatedMotion::kHand, 1.0);
  const Simulation slow = simulate(options);
  options.rate_hz = 160.0;
  const Simulation fast = simulate(options);
  for (std::size_t k = 0; k < slow.truth.t.size(); ++k) {
    ASSERT_EQ(slow.truth.t[k], fast.truth.t[2 * k]);
    ASSERT_LT((slow.truth.nRb[k].matrix() - fast.truth.nRb[2 * k].matrix()).norm(), 1e-9);
  }
}

TEST(Simulate, a_sensor_that_is_moved_reads_its_acceleration) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHandHeld;
  options.noise_factor = 0.0;
  options.rate_hz = 500.0;
  options.duration_s = 30.0;
  options.displacement_m = 0.2;
  const Simulation s = simulate(options);
  const std::vector<Vector3>&p = s.truth.p, &v = s.truth.v;
  ASSERT_EQ(p.size(), s.truth.t.size());
  ASSERT_EQ(v.size(), s.truth.t.size());
  const double h = 1.0 / options.rate_hz;
  const Vector3 up(0.0, 0.0, s.truth.gravity);
  double squares = 0.0, moving = 0.0;
  for (std::size_t k = 1; k + 1 < p.size(); ++k) {
    ASSERT_LT((v[k] - (p[k + 1] - p[k - 1]) / (2.0 * h)).norm(), 2e-4);
    const Vector3 acceleration = (p[k + 1] - 2.0 * p[k] + p[k - 1]) / (h * h);
    const Vector3 read =
        s.truth.nRb[k] * Vector3(s.recording.acc.v[k] - s.truth.parameters.acc_bias);
    ASSERT_LT((read - up - acceleration).norm(), 0.02) << "at " << s.truth.t[k] << " s";
    if (p[k].isZero()) continue;
    squares += p[k].squaredNorm();
    moving += 1.0;
  }
  EXPECT_NEAR(std::sqrt(squares / moving), 0.2, 0.01);
  EXPECT_GT(moving * h, 20.0);
}

TEST(Simulate, a_moved_hand_is_still_in_its_rests_and_within_reach_otherwise) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHandHeld;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    options.seed = seed;
    const Simulation s = simulate(options);
    for (std::size_t k = 0; k < 240; ++k) {
      EXPECT_TRUE(s.truth.p[k].isZero() && s.truth.v[k].isZero());
      EXPECT_TRUE(s.truth.p[9599 - k].isZero() && s.truth.v[9599 - k].isZero());
    }
    double squares = 0.0, farthest = 0.0;
    for (const Vector3& p : s.truth.p) {
      squares += p.squaredNorm() / 9600.0;
      farthest = std::max(farthest, p.norm());
    }
    EXPECT_GT(std::sqrt(squares), 0.04);
    EXPECT_LT(std::sqrt(squares), 0.31);
    EXPECT_LT(farthest, 1.2);
  }
}

TEST(Simulate, refuses_options_out_of_range_and_says_what_to_do) {
  const auto refused = [](auto change) {
    SimulationOptions options;
    change(options);
    try {
      simulate(options);
    } catch (const InputError& error) {
      return !error.remedy.empty();
    }
    return false;
  };
  using O = SimulationOptions;
  EXPECT_TRUE(refused([](O& o) { o.rate_hz = 0.0; }));
  EXPECT_TRUE(refused([](O& o) { o.rate_hz = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](O& o) { o.mag_ratio = 0; }));
  EXPECT_TRUE(refused([](O& o) { o.magnetometers = 0; }));
  EXPECT_TRUE(refused([](O& o) { o.duration_s = -1.0; }));
  EXPECT_TRUE(refused([](O& o) { o.noise.gyr = -1.0; }));
  EXPECT_TRUE(refused([](O& o) { o.noise_factor = -1.0; }));
  EXPECT_TRUE(refused([](O& o) { o.duration_s = 2.0, o.rest_s = 3.0; }));
}

TEST(TruthJson, has_the_names_of_a_calibration_file) {
  SimulationOptions options = short_options(SimulatedMotion::kHand, 2.0);
  options.seed = std::numeric_limits<std::uint64_t>::max();
  const SimulationTruth truth = simulate(options).truth;
  const nlohmann::json json = nlohmann::json::parse(to_json(truth, options).dump());
  const SensorParameters& p = truth.parameters;
  ASSERT_EQ(json.at("magnetometers").size(), 2u);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_EQ(json.at("accelerometer").at("bias").at(i), p.acc_bias[row]);
    EXPECT_EQ(json.at("gyroscope").at("bias").at(i), p.gyr_bias[row]);
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_EQ(json.at("magnetometers").at(1).at("distortion").at(i).at(j),
                p.mag[1].distortion(row, static_cast<Eigen::Index>(j)));
    }
    EXPECT_EQ(json.at("magnetometers").at(1).at("bias").at(i), p.mag[1].bias[row]);
  }
  EXPECT_EQ(json.at("magnetometers").at(1).at("name"), "mag2");
  EXPECT_NEAR(json.at("field").at("dip_deg").get<double>(), p.dip_rad * 57.29577951308232, 1e-9);
  EXPECT_NEAR(std::pow(json.at("field").at("strength_uT").get<double>(), 3),
              p.mag[0].distortion.determinant(), 1e-7);
  EXPECT_EQ(json.at("seed"), options.seed);
  EXPECT_EQ(json.at("rate_hz"), 80.0);
  EXPECT_EQ(json.at("motion"), "hand");
  EXPECT_EQ(json.at("noise").at("acc"), 0.04);
}

}  // namespace
}  // namespace magimu
