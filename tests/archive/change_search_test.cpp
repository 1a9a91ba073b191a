// SPDX-License-Identifier: BSD-3-Clause
#include "archive/change_search.h"

#include <gmock/gmock.h>

#include <Eigen/Dense>

#include "archive/change_size.h"
#include "tests/archive/change_problems.h"

namespace magimu {
namespace {

using test::draw_device;
using test::DrawnDevice;

constexpr std::size_t kRecordings = 12;

std::vector<VectorXd> unchanging() { return std::vector<VectorXd>(kRecordings, VectorXd::Zero(6)); }

TEST(ChangeSearch, dates_a_step_of_six_sigmas_to_its_recording) {
  int found = 0, dated = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::size_t at = 1 + seed % (kRecordings - 1);
    std::vector<VectorXd> truth = unchanging();
    const VectorXd step = test::step_of(draw_device(truth, seed), 6.0, seed);
    for (std::size_t k = at; k < kRecordings; ++k) truth[k] += step;
    const ChangeHistory history = find_changes(draw_device(truth, seed).problem);
    if (history.changes.empty()) continue;
    const DeviceChange& c = history.changes.front().change;
    found += c.kind == ChangeKind::kStep && c.group == 0;
    dated += c.kind == ChangeKind::kStep && c.at == at;
  }
  EXPECT_GE(found, 18);
  EXPECT_GE(dated, 18);
}

TEST(ChangeSearch, finds_nothing_where_nothing_changes) {
  int flagged = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    flagged += !find_changes(draw_device(unchanging(), 100 + seed).problem).changes.empty();
  }
  EXPECT_LE(flagged, 2);
}

TEST(ChangeSearch, tells_a_steady_drift_from_a_step) {
  std::vector<VectorXd> truth = unchanging();
  const VectorXd whole = test::step_of(draw_device(truth, 7), 20.0, 7);
  for (std::size_t k = 0; k < kRecordings; ++k) truth[k] += whole * double(k) / (kRecordings - 1);
  const ChangeHistory history = find_changes(draw_device(truth, 7).problem);
  ASSERT_EQ(history.changes.size(), 1u);
  EXPECT_EQ(history.changes.front().change.kind, ChangeKind::kTrend);
  EXPECT_EQ(history.changes.front().change.group, 0u);
}

TEST(ChangeSearch, tells_a_random_walk_from_scatter_without_memory) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  std::vector<VectorXd> walk(25, VectorXd::Zero(6)), scatter = walk;
  const DrawnDevice plain = draw_device(walk, 12);
  const MatrixXd L = plain.sigma.topLeftCorner(3, 3).llt().matrixL();
  Vector3 state = Vector3::Zero();
  for (std::size_t k = 0; k < walk.size(); ++k) {
    state += 3.0 * L * Vector3(normal(random), normal(random), normal(random));
    walk[k].head<3>() = state;
    scatter[k].head<3>() = 8.0 * L * Vector3(normal(random), normal(random), normal(random));
  }
  const ChangeHistory walked = find_changes(draw_device(walk, 12).problem);
  ASSERT_FALSE(walked.changes.empty());
  EXPECT_EQ(walked.changes.front().change.kind, ChangeKind::kWalk);
  const ChangeHistory scattered = find_changes(draw_device(scatter, 12).problem);
  ASSERT_FALSE(scattered.changes.empty());
  EXPECT_EQ(scattered.changes.front().change.kind, ChangeKind::kScatter);
}

TEST(ChangeSearch, finds_two_steps_at_their_dates) {
  std::vector<VectorXd> truth = unchanging();
  const DrawnDevice plain = draw_device(truth, 21);
  const VectorXd first = test::step_of(plain, 12.0, 1), second = test::step_of(plain, 10.0, 2);
  for (std::size_t k = 4; k < kRecordings; ++k) truth[k] += first;
  for (std::size_t k = 9; k < kRecordings; ++k) truth[k] += second;
  const ChangeHistory history = find_changes(draw_device(truth, 21).problem);
  std::vector<std::size_t> dates;
  for (const FoundChange& c : history.changes) dates.push_back(c.change.at);
  EXPECT_THAT(dates, testing::UnorderedElementsAre(4u, 9u));
}

// The first of two steps is no better than a drift until the second is in the model, too: what is
// told of it is what it is worth beside that.
TEST(ChangeSearch, a_change_is_judged_beside_all_others) {
  std::vector<VectorXd> truth = unchanging();
  const DrawnDevice plain = draw_device(truth, 21);
  const VectorXd first = test::step_of(plain, 60.0, 1), second = test::step_of(plain, 50.0, 2);
  for (std::size_t k = 4; k < kRecordings; ++k) truth[k] += first;
  for (std::size_t k = 9; k < kRecordings; ++k) truth[k] += second;
  const ChangeHistory history = find_changes(draw_device(truth, 21).problem);
  ASSERT_EQ(history.changes.size(), 2u);
  for (const FoundChange& found : history.changes) {
    EXPECT_TRUE(found.most_likely);
    EXPECT_GT(found.probability, 0.5);
  }
}

TEST(ChangeSearch, a_huge_step_has_a_probability_of_one_at_most_and_its_own_size) {
  std::vector<VectorXd> truth = unchanging();
  const DrawnDevice plain = draw_device(truth, 31);
  const VectorXd step = test::step_of(plain, 1e5, 3);
  for (std::size_t k = 5; k < kRecordings; ++k) truth[k] += step;
  const ChangeProblem problem = draw_device(truth, 31).problem;
  const ChangeHistory history = find_changes(problem);
  ASSERT_FALSE(history.changes.empty());
  const FoundChange& found = history.changes.front();
  EXPECT_LE(found.probability, 1.0);
  EXPECT_LE(found.date_probability, 1.0);
  EXPECT_GT(found.change.size, 1e4);
  EXPECT_LT(found.change.size, 1e6);
  const VectorXd one = VectorXd::Ones(step.size());
  const ChangeSize size = size_of_change(problem, history, 0, one, one, 1.0);
  EXPECT_NEAR(size.value, step.norm(), 4.0 * size.sigma);
  EXPECT_LT(size.sigma, 1e-3 * size.value);
}

TEST(ChangeSearch, a_drift_has_its_size_from_first_to_last) {
  std::vector<VectorXd> truth = unchanging();
  const VectorXd whole = test::step_of(draw_device(truth, 7), 40.0, 7);
  for (std::size_t k = 0; k < kRecordings; ++k) truth[k] += whole * double(k) / (kRecordings - 1);
  const ChangeProblem problem = draw_device(truth, 7).problem;
  const ChangeHistory history = find_changes(problem);
  ASSERT_EQ(history.changes.size(), 1u);
  const VectorXd one = VectorXd::Ones(whole.size());
  const ChangeSize size = size_of_change(problem, history, 0, one, one, 1.0);
  EXPECT_NEAR(size.value, whole.norm(), 4.0 * size.sigma);
  EXPECT_LT(size.sigma, 0.2 * size.value);
}

TEST(ChangeSearch, one_recording_has_no_history) {
  const ChangeHistory history = find_changes(draw_device({VectorXd::Zero(6)}, 2).problem);
  EXPECT_TRUE(history.changes.empty());
  EXPECT_EQ(history.smoothed.size(), 1u);
}

}  // namespace
}  // namespace magimu
