// SPDX-License-Identifier: BSD-3-Clause
// The filter in a simulated room of dipoles, its samples, its layouts.
#include "navigation/array_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "navigation/array_layout.h"
#include "navigation/navigation_output.h"
#include "navigation/navigation_study.h"
#include "navigation/truncation.h"
#include "recording/arrays/array_mat.h"
#include "sim/array_room.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

std::vector<NavigationCase> rooms(unsigned count) {
  std::vector<NavigationCase> cases;
  for (unsigned seed = 1; seed <= count; ++seed) cases.push_back(simulated_case(seed));
  return cases;
}

TEST(ArraySamples, steps_of_exact_readings_lead_along_the_true_motion) {
  ArrayRoomOptions room;
  room.positions = {Vector3::Zero()};
  room.acc_noise = room.gyr_noise = room.mag_noise = room.acc_bias = room.gyr_bias = 0.0;
  const Recording recording = simulate_array(room);
  const auto end_error = [&](StepReadings readings) {
    const ArraySamples samples = array_samples(recording, room.positions, readings);
    NavigationOptions options;
    options.use_magnetometers = false;
    options.filter.order = 1;
    options.filter.field = ArrayFilterOptions::published_process(1);
    ArraySamples more = samples;  // a layout that permits the order; its readings are not used
    more.positions = published_array_layout();
    const std::vector<Vector3>& p = samples.true_p;
    const Vector3 v = (-3.0 * p[0] + 4.0 * p[1] - p[2]) * (room.rate_hz / 2.0);
    options.start = NavigationStart{p[0], v, samples.true_nRb[0]};
    const NavigationRun run = navigate(more, options);
    return (run.states.back().p - samples.true_p.back()).norm();
  };
  EXPECT_LT(end_error(StepReadings::kMean), 0.05);
}

TEST(ArraySamples, a_slow_magnetometer_counts_once_and_gaps_not_at_all) {
  ArrayRoomOptions room;
  room.positions = published_array_layout();
  room.duration_s = 1.0;
  Recording recording = simulate_array(room);
  for (VectorSeries& mag : recording.mag) {
    VectorSeries slow;
    for (std::size_t k = 0; k < mag.size(); k += 4) {
      if (k < 40 || k > 60) slow.push_back(mag.t[k] + 0.001, mag.v[k]);
    }
    mag = slow;
  }
  const ArraySamples samples = array_samples(recording, room.positions);
  const auto used = std::count(samples.measured.begin(), samples.measured.end(), true);
  EXPECT_GT(used, 14);
  EXPECT_LE(used, 20);
  for (std::size_t k = 42; k < 60; ++k) EXPECT_FALSE(samples.measured[k]) << k;
}

TEST(ArrayFilter, in_rooms_of_dipoles_a_coloured_truncation_is_nearer_and_more_honest) {
  const std::vector<NavigationCase> cases = rooms(4);
  NavigationVariant white{"white", {}, StepReadings::kMean, false};
  white.options.filter.constrain_yaw = true;
  NavigationVariant coloured = white;
  coloured.coloured = true;
  const NavigationSummary w = run_variant(white, cases).summary;
  const NavigationSummary c = run_variant(coloured, cases).summary;
  EXPECT_LT(c.position_rmse, 1.05 * w.position_rmse);
  EXPECT_LT(c.position_nees, w.position_nees);
  EXPECT_GE(c.yaw_sigma, c.yaw_sigma_at_start * 0.999);
}

// Derivatives at noisy gradients are why a filter claims too much in weak fields.
TEST(ArrayFilter, in_a_weak_field_claims_are_the_better_the_truer_the_gradients_of_derivatives) {
  std::vector<NavigationCase> cases;
  for (unsigned seed = 1; seed <= 4; ++seed) cases.push_back(simulated_case(seed, 0.5));
  NavigationVariant published = navigation_variants().back();
  published.shrink_gradients = false;
  const NavigationSummary estimated = run_variant(published, cases).summary;
  const NavigationSummary shrunk = run_variant(navigation_variants().back(), cases).summary;
  const NavigationSummary at_truth = run_variant(at_true_field_variant(), cases).summary;
  // 99.99 and 99 % of chi-square with 12 degrees of freedom, over 12.
  EXPECT_GT(estimated.position_nees, 3.26);
  EXPECT_LT(at_truth.position_nees, 2.18);
  EXPECT_LT(at_truth.position_rmse, estimated.position_rmse);
  EXPECT_LT(shrunk.position_nees, 0.25 * estimated.position_nees);
  EXPECT_LT(shrunk.position_rmse, 1.05 * estimated.position_rmse);
}

TEST(ArrayFilter, finds_the_biases_of_magnetometers) {
  NavigationCase c = simulated_case(1);
  const Vector3 bias(0.8, -0.5, 0.3);
  for (Vector3& v : c.recording.mag[7].v) v += bias;
  const ArraySamples samples = array_samples(c.recording, c.positions);
  ArrayFilterOptions options;
  options.mag_bias_sigma = 0.5;
  options = with_truncation(options, samples);
  ArrayFilter filter(options, c.positions);
  NavigationState state;
  state.p = c.start.p;
  state.nRb = c.start.nRb;
  state.theta = VectorXd::Zero(FieldBasis::size_of(options.order));
  filter.start(state);
  filter.start_field(samples.mag.col(0));
  for (std::size_t k = 0; k + 1 < 200; ++k) {
    filter.propagate(samples.acc[k], samples.gyr[k], samples.t[k + 1] - samples.t[k]);
    filter.update(samples.mag.col(static_cast<Eigen::Index>(k + 1)));
  }
  for (int i = 0; i < 3; ++i) {
    // A third of it within two seconds: the claim of its accuracy is too good (bench/README.md).
    EXPECT_NEAR(filter.mag_biases()[21 + i], bias[i], 0.3);
  }
}

TEST(ArrayFilter, position_aid_holds_the_position) {
  const NavigationCase c = simulated_case(2);
  const ArraySamples samples = array_samples(c.recording, c.positions);
  NavigationOptions options;
  options.start = c.start;
  options.aided_s = 100.0;
  const NavigationRun run = navigate(samples, options);
  EXPECT_LT(navigation_error(run, samples, run.t.size() - 1).position.norm(), 0.05);
}

// Six on a plane tell order 1 only, and the coloured truncation takes an order more.
TEST(ArrayFilter, says_which_order_the_array_can_tell) {
  ArraySamples samples;
  for (int i = 0; i < 6; ++i)
    samples.positions.emplace_back(0.05 * (i % 3) + 0.01 * (i / 3), 0.06 * (i / 3), 0.0);
  ASSERT_EQ(highest_order(samples.positions), 1);
  const auto remedy = [&](int order) {
    ArrayFilterOptions options;
    options.order = order;
    try {
      with_truncation(options, samples);
    } catch (const InputError& e) {
      return e.remedy;
    }
    return std::string();
  };
  for (const int order : {1, 2}) EXPECT_EQ(remedy(order), "give `--order 1 --truncation white`");
  ArrayFilterOptions options;
  options.order = 1;
  options.field = ArrayFilterOptions::published_process(1);
  EXPECT_NO_THROW(ArrayFilter(options, samples.positions));
  EXPECT_EQ(highest_order(published_array_layout()), FieldBasis::kHighestOrder);
}

TEST(ArrayFilter, refuses_an_order_that_the_array_cannot_tell) {
  const std::vector<Vector3> line{{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.3, 0, 0}, {0.4, 0, 0}};
  EXPECT_THROW(ArrayFilter({}, line), InputError);
  EXPECT_THROW(ArrayFilter({}, {Vector3::Zero()}), InputError);
  EXPECT_EQ(highest_order(line), 0);
}

TEST(ArrayRoom, field_is_free_of_curl_and_divergence) {
  const ArrayRoomOptions room;
  const Vector3 p(0.4, -0.3, -0.2);
  Matrix3 gradient;
  for (int i = 0; i < 3; ++i) {
    const Vector3 h = 1e-4 * Vector3::Unit(i);
    gradient.col(i) = (room_field(room, p + h) - room_field(room, p - h)) / 2e-4;
  }
  EXPECT_GT(gradient.norm(), 0.1);
  EXPECT_NEAR(gradient.trace(), 0.0, 1e-5);
  EXPECT_LT((gradient - gradient.transpose()).norm(), 1e-5);
}

TEST(NavigationOutput, has_a_row_a_sample_and_the_covariance_in_n) {
  const NavigationCase c = simulated_case(3);
  NavigationOptions options;
  options.start = c.start;
  const NavigationRun run = navigate(array_samples(c.recording, c.positions), options);
  const std::string csv = navigation_csv(run);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), long(run.t.size()) + 1);
  const std::string header = csv.substr(0, csv.find('\n'));
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), 10 + 45);
  const auto P = covariance_in_n(run, 300);
  EXPECT_NEAR(
      P(8, 8),
      std::pow(navigation_error(run, array_samples(c.recording, c.positions), 300).yaw_sigma, 2),
      1e-12);
  EXPECT_EQ(navigation_json(run).size(), run.t.size());
}

TEST(ArrayLayout, is_read_and_its_faults_are_named_by_line) {
  const test::TempFolder folder;
  const auto places =
      read_array_layout(folder.write("a.csv", "# board\nx,y,z\n0.1, 0,0\n0,-0.2,1e-3\n"));
  ASSERT_EQ(places.size(), 2u);
  EXPECT_EQ(places[1], Vector3(0, -0.2, 1e-3));
  const auto error = [&](const std::string& text) {
    return test::error_of([&] { read_array_layout(folder.write("b.csv", text)); });
  };
  EXPECT_EQ(error("x,y,z\n1,2\n").line, 2);
  EXPECT_EQ(error("x,y,z\n0,0,nan\n").line, 2);
  EXPECT_EQ(error("x,y,z\n0,0,100\n").line, 2);  // cm
  EXPECT_EQ(error("0,0,0\n").line, 1);
  error("");
}

}  // namespace
}  // namespace magimu
