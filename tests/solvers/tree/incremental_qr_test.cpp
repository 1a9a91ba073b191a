// SPDX-License-Identifier: BSD-3-Clause
// Data that come window by window must end where all of them at once do.
#include "solvers/tree/incremental_qr.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "graph/numerical_error.h"
#include "solvers/levenberg_marquardt.h"
#include "solvers/marginals.h"
#include "tests/solvers/windowed.h"

namespace magimu {
namespace {

using test::is_global;
using test::Stream;

const std::vector<Key> kCalibration = {key::acc_bias, key::gyr_bias, key::distortion, key::mag_bias,
                                       key::dip};

// The largest difference of the globals in standard deviations of the batch solution.
double sigmas_from_batch(const IncrementalQr& estimator, const Values& batch,
                         const MatrixXd& covariance) {
  VectorXd difference(covariance.rows());
  Eigen::Index at = 0;
  for (const Key key : kCalibration) {
    Values a, b;
    a.insert_from(batch, key);
    b.insert_from(estimator.globals(), key);
    const VectorXd d = a.local_coordinates(b);
    difference.segment(at, d.size()) = d;
    at += d.size();
  }
  return (difference.array().abs() / covariance.diagonal().array().sqrt()).maxCoeff();
}

void expect_batch_solution(const Stream& s, IncrementalQr& estimator) {
  for (int i = 0; i < 3; ++i) estimator.idle();
  const Result batch = LevenbergMarquardt(s.all).optimize(s.start);
  ASSERT_TRUE(batch.converged()) << batch.message;
  const MatrixXd P = Marginals(s.all, batch.values).covariance(kCalibration);
  EXPECT_LT(sigmas_from_batch(estimator, batch.values, P), 1e-3);
  const MatrixXd Q = estimator.covariance(kCalibration);
  EXPECT_LT((Q - P)
                .cwiseAbs()
                .cwiseQuotient(P.diagonal().cwiseSqrt() * P.diagonal().cwiseSqrt().transpose())
                .maxCoeff(),
            1e-3);
  EXPECT_NEAR(estimator.cost(), batch.cost_final, 1e-6 * batch.cost_final);
  const Values estimate = estimator.estimate();
  for (const Values::Slot& slot : batch.values.slots()) {
    Values a, b;
    a.insert_from(batch.values, slot.key);
    b.insert_from(estimate, slot.key);
    EXPECT_LT(a.local_coordinates(b).norm(), 1e-4) << to_string(slot.key);
  }
}

void run(const Stream& s, IncrementalQr& estimator) {
  for (const Stream::Window& w : s.windows) estimator.update(w.factors, w.values, w.removable);
}

TEST(IncrementalQr, a_chain_of_rotations_ends_at_the_batch_solution) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Stream s = test::rotations_in_windows(seed, 200, 10);
    IncrementalQr estimator({.is_global = is_global});
    run(s, estimator);
    expect_batch_solution(s, estimator);
  }
}

TEST(IncrementalQr, two_relinearized_windows_an_update_are_enough) {
  const Stream s = test::rotations_in_windows(4, 400, 5);
  IncrementalQr estimator({.is_global = is_global, .eager_windows = 10});
  run(s, estimator);
  expect_batch_solution(s, estimator);
}

TEST(IncrementalQr, several_chains_share_their_globals) {
  const Stream s = test::rotations_in_windows(5, 120, 10, 3);
  IncrementalQr estimator({.is_global = is_global});
  run(s, estimator);
  expect_batch_solution(s, estimator);
}

TEST(IncrementalQr, nodes_with_velocity_and_position_end_at_the_batch_solution) {
  const Stream s = test::hand_held_in_windows(6, 160, 8);
  IncrementalQr estimator({.is_global = is_global});
  run(s, estimator);
  expect_batch_solution(s, estimator);
}

TEST(IncrementalQr, windows_at_once_or_one_by_one_are_the_same) {
  const Stream s = test::rotations_in_windows(7, 100, 10);
  IncrementalQr one_by_one({.is_global = is_global}), at_once({.is_global = is_global});
  run(s, one_by_one);
  for (const Stream::Window& w : s.windows) at_once.append(w.factors, w.values, w.removable);
  for (int i = 0; i < 8; ++i) at_once.idle();
  for (int i = 0; i < 3; ++i) one_by_one.idle();
  const MatrixXd P = one_by_one.covariance(kCalibration);
  EXPECT_LT(sigmas_from_batch(at_once, one_by_one.globals(), P), 1e-3);
}

// Bounded by the tree's depth, whatever the length: the work of an update, not its time.
TEST(IncrementalQr, an_update_does_no_more_than_a_logarithm_of_the_windows) {
  const Stream s = test::rotations_in_windows(8, 1200, 3);
  const int relinearized = 2;
  IncrementalQr estimator(
      {.is_global = is_global, .eager_windows = 20, .relinearized = relinearized});
  for (std::size_t i = 0; i < s.windows.size(); ++i) {
    const Stream::Window& w = s.windows[i];
    const UpdateResult result = estimator.update(w.factors, w.values, w.removable);
    if (int(i) < 20) continue;
    EXPECT_LE(int(result.relinearized.size()), relinearized);
    EXPECT_LE(result.merges, (1 + relinearized) * (1 + int(std::log2(double(i)))));
  }
}

TEST(IncrementalQr, factors_between_any_nodes_of_a_window_are_taken_exactly) {
  test::Problem p = test::pose_graph(9, 30);
  IncrementalQr estimator({.is_global = [](Key) { return false; }});
  estimator.update(p.graph, p.start);
  for (int i = 0; i < 8; ++i) estimator.idle();
  const Result batch = LevenbergMarquardt(p.graph).optimize(p.start);
  ASSERT_TRUE(batch.converged());
  EXPECT_LT(test::sigmas_between(p.graph, batch.values, estimator.estimate()), 1e-3);
}

TEST(IncrementalQr, a_loop_to_an_older_window_is_refused_by_name_and_changes_nothing) {
  const Stream s = test::rotations_in_windows(10, 40, 10);
  IncrementalQr estimator({.is_global = is_global});
  for (int i = 0; i < 3; ++i) {
    estimator.update(s.windows[std::size_t(i)].factors, s.windows[std::size_t(i)].values,
                     s.windows[std::size_t(i)].removable);
  }
  const Values before = estimator.estimate();
  Stream::Window loop = s.windows[3];
  loop.factors.add(RelativeRotationFactor(R(5), R(35), Rot3(), Noise<3>::isotropic(1.0)));
  try {
    estimator.update(loop.factors, loop.values, loop.removable);
    FAIL() << "the loop was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("(R5, R35)"));
  }
  EXPECT_EQ(estimator.windows(), 3);
  const Values after = estimator.estimate();
  EXPECT_THAT(after.data(), testing::ElementsAreArray(before.data()));
  estimator.update(s.windows[3].factors, s.windows[3].values, s.windows[3].removable);
  expect_batch_solution(s, estimator);
}

std::string complaint(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(IncrementalQr, a_variable_without_a_value_is_not_taken_for_a_loop) {
  const Stream s = test::rotations_in_windows(3, 40, 10);
  IncrementalQr estimator({.is_global = is_global});
  const auto& first = s.windows[0];
  EXPECT_THAT(complaint([&] { estimator.update(first.factors, Values(), first.removable); }),
              testing::AllOf(testing::HasSubstr("insert an initial value for it"),
                             testing::Not(testing::HasSubstr("loop"))));
  EXPECT_EQ(estimator.windows(), 0);
}

TEST(IncrementalQr, the_covariance_of_an_earlier_node_is_found_elsewhere) {
  const Stream s = test::rotations_in_windows(3, 40, 10);
  IncrementalQr estimator({.is_global = is_global});
  run(s, estimator);
  EXPECT_THAT(complaint([&] { estimator.covariance(R(3)); }),
              testing::HasSubstr("Marginals(estimator.graph(), estimator.estimate())"));
  EXPECT_THAT(complaint([&] { estimator.covariance(R(999)); }),
              testing::HasSubstr("R999 has come with no update"));
  EXPECT_EQ(Marginals(estimator.graph(), estimator.estimate()).covariance(R(3)).rows(), 3);
}

TEST(IncrementalQr, it_has_to_be_said_what_is_global) {
  EXPECT_THAT(complaint([] { IncrementalQr estimator(IncrementalQrOptions{}); }),
              testing::HasSubstr("is_global is not set"));
}

TEST(IncrementalQr, a_window_that_is_not_there_is_refused_by_its_number) {
  const Stream s = test::rotations_in_windows(11, 60, 10);
  IncrementalQr estimator({.is_global = is_global});
  const auto refuses = [&](int window) {
    const std::string number = "no window " + std::to_string(window);
    const std::vector<std::function<void()>> calls = {
        [&] { estimator.remove(window); },
        [&] { estimator.restore(window); },
        [&] { (void)estimator.removed(window); },
        [&] { estimator.innovation(window); },
        [&] { estimator.conclude(window, true); },
        [&] { estimator.replace_factors(window); },
        [&] { (void)estimator.estimate(window, window + 1); },
    };
    for (const auto& call : calls) EXPECT_THAT(complaint(call), testing::HasSubstr(number));
  };
  refuses(0);
  run(s, estimator);
  for (const int window : {-1, estimator.windows(), 9999}) refuses(window);
  EXPECT_THAT(complaint([&] { estimator.replace_factors(0); }), testing::HasSubstr("make_again"));
  const std::vector<int> blocks(std::size_t(estimator.windows()), 0);
  for (const int n : {-1, 0})
    EXPECT_THAT(complaint([&] { (void)estimator.scores(blocks, n); }),
                testing::HasSubstr("a block for each"));
  EXPECT_THAT(complaint([&] { (void)estimator.scores({}, 1); }),
              testing::HasSubstr("a block for each"));
}

TEST(IncrementalQr, before_the_first_window_there_is_nothing_but_no_crash_either) {
  IncrementalQr estimator({.is_global = is_global});
  EXPECT_EQ(estimator.front().size(), 0);
  EXPECT_EQ(estimator.estimate().size(), 0);
  EXPECT_EQ(estimator.graph().size(), 0);
  EXPECT_EQ(estimator.cost(), 0.0);
  EXPECT_TRUE(estimator.null_space().empty());
  EXPECT_FALSE(estimator.held().has_value());
  estimator.idle();
  EXPECT_THROW((void)estimator.covariance(key::mag_bias), std::invalid_argument);
  EXPECT_THROW((void)estimator.columns_of(key::mag_bias), std::invalid_argument);
}

TEST(IncrementalQr, a_window_can_be_taken_out_and_put_back) {
  Stream s = test::rotations_in_windows(11, 120, 10);
  IncrementalQr estimator({.is_global = is_global});
  run(s, estimator);
  estimator.remove(4);
  FactorGraph without;
  for (std::size_t i = 0; i < s.windows.size(); ++i) {
    for (const auto& batch : s.windows[i].factors.batches()) without.add_batch(batch->clone());
    for (const auto& batch : s.windows[i].removable.batches()) {
      if (i != 4) without.add_batch(batch->clone());
    }
  }
  for (int i = 0; i < 3; ++i) estimator.idle();
  const Result batch = LevenbergMarquardt(without).optimize(s.start);
  EXPECT_NEAR(estimator.cost(), batch.cost_final, 1e-6 * batch.cost_final);
  estimator.restore(4);
  expect_batch_solution(s, estimator);
}

TEST(IncrementalQr, a_window_may_be_looked_at_before_it_is_taken_in) {
  const Stream s = test::rotations_in_windows(16, 300, 10);
  IncrementalQr estimator({.is_global = is_global, .eager_windows = 6});
  std::vector<int> left_out;
  for (std::size_t i = 0; i < s.windows.size(); ++i) {
    const Stream::Window& w = s.windows[i];
    const int window = estimator.update(w.factors, w.values, w.removable, i >= 5).window;
    if (i < 5) continue;
    EXPECT_TRUE(estimator.removed(window));
    EXPECT_EQ(estimator.innovation(window).dof, 30);
    const bool take_in = i % 4 != 0;
    estimator.conclude(window, take_in);
    EXPECT_EQ(estimator.removed(window), !take_in);
    if (!take_in) left_out.push_back(window);
  }
  for (const int window : left_out) {
    const double without = estimator.cost();
    const Innovation innovation = estimator.innovation(window);
    estimator.restore(window);
    EXPECT_NEAR(estimator.cost(), without + 0.5 * innovation.squares, 1e-9 * without);
  }
  expect_batch_solution(s, estimator);
}

// A window that begins a chain is not held back: it is in the tree before it is solved for, and old
// windows that have drifted must not be looked at in between.
TEST(IncrementalQr, a_window_of_another_chain_may_be_looked_at_too) {
  const Stream s = test::rotations_in_windows(17, 240, 5, 6);
  IncrementalQr estimator(
      {.is_global = is_global, .eager_windows = 6, .relinearized = 1, .tolerance = 1e-5});
  double cost = 0.0;
  for (std::size_t i = 0; i < s.windows.size(); ++i) {
    const Stream::Window& w = s.windows[i];
    const int window = estimator.update(w.factors, w.values, w.removable, i >= 10).window;
    if (i >= 10) estimator.conclude(window, true);
    if (i > 10) {
      EXPECT_LT(estimator.cost(), cost + 500.0) << i;  // of some 45 residuals
    }
    cost = estimator.cost();
  }
  expect_batch_solution(s, estimator);
}

// Chi-square with as many degrees of freedom as the window has magnetometer residuals: 30 windows
// of 30, so that the mean of NIS / dof has a standard deviation of 0.047.
TEST(IncrementalQr, the_innovation_of_a_window_is_chi_square) {
  double sum = 0.0;
  int n = 0;
  for (const unsigned seed : {12U, 13U, 14U}) {
    const Stream s = test::rotations_in_windows(seed, 200, 10);
    IncrementalQr estimator({.is_global = is_global});
    run(s, estimator);
    for (int i = 0; i < 3; ++i) estimator.idle();
    for (int w = 5; w < 15; ++w, ++n) {
      const Innovation innovation = estimator.innovation(w);
      EXPECT_EQ(innovation.dof, 30);
      sum += innovation.squares / innovation.dof;
    }
  }
  EXPECT_NEAR(sum / n, 1.0, 4.0 * 0.047);
}

TEST(IncrementalQr, what_is_undetermined_is_named_and_does_not_move) {
  FactorGraph graph;
  Values start;
  const Noise<3> noise = Noise<3>::isotropic(0.1);
  for (int i = 0; i < 5; ++i) {
    start.insert(R(i), Rot3::Exp(Vector3(0.1 * i, 0.0, 0.0)));
    if (i > 0) graph.add(RelativeRotationFactor(R(i - 1), R(i), Rot3(), noise));
  }
  start.insert(key::gyr_bias, Vector3(1.0, 2.0, 3.0));
  graph.add(PriorFactor<Vector3>(key::gyr_bias, Vector3::Zero(), noise));
  start.insert(key::dip, 0.7);
  IncrementalQr estimator({.is_global = is_global});
  estimator.update(graph, start);
  EXPECT_EQ(estimator.null_space().size(), 1u);
  EXPECT_EQ(estimator.globals().at<double>(key::dip), 0.7);
  EXPECT_LT(estimator.globals().at<Vector3>(key::gyr_bias).norm(), 1e-12);
  EXPECT_NO_THROW(estimator.covariance(key::gyr_bias));
  try {
    estimator.covariance(key::dip);
    FAIL() << "a covariance of what is undetermined";
  } catch (const std::domain_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("i0"));
  }
}

// A factor of a reading that is not finite, or far too large for double arithmetic, removable or
// not, while another window is held back or not.
TEST(IncrementalQr, a_window_that_is_not_finite_is_refused_by_name_and_changes_nothing) {
  const Stream s = test::rotations_in_windows(16, 100, 10);
  for (const double size :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e170}) {
    IncrementalQr undisturbed({.is_global = is_global}), disturbed({.is_global = is_global});
    const PriorFactor<Vector3> bad(key::acc_bias, Vector3::Constant(size),
                                   Noise<3>::isotropic(1.0));
    for (std::size_t i = 0; i < s.windows.size(); ++i) {
      const Stream::Window& w = s.windows[i];
      for (const bool removable : {false, true}) {
        if (removable && i % 2 == 0) continue;
        Stream::Window damaged = w;
        (removable ? damaged.removable : damaged.factors).add(bad);
        try {
          disturbed.update(damaged.factors, damaged.values, damaged.removable, removable);
          FAIL() << "a window that is not finite at " << size;
        } catch (const NumericalError& error) {
          EXPECT_THAT(error.what(), testing::HasSubstr("factor on (a0)"));
        }
        ASSERT_EQ(disturbed.windows(), undisturbed.windows());
      }
      const bool held = i % 3 == 1;  // until the next one comes, or taken in
      for (IncrementalQr* e : {&undisturbed, &disturbed}) {
        const int window = e->update(w.factors, w.values, w.removable, held).window;
        if (held && i % 2 == 0) e->conclude(window, true);
      }
    }
    EXPECT_TRUE(std::ranges::equal(disturbed.estimate().data(), undisturbed.estimate().data()));
    EXPECT_EQ(disturbed.cost(), undisturbed.cost());
    EXPECT_EQ(disturbed.covariance(kCalibration), undisturbed.covariance(kCalibration));
  }
}

TEST(IncrementalQr, the_same_windows_give_the_same_bits) {
  const Stream s = test::rotations_in_windows(15, 200, 5);
  IncrementalQr a({.is_global = is_global}), b({.is_global = is_global});
  run(s, a);
  run(s, b);
  EXPECT_EQ(a.globals().local_coordinates(b.globals()).norm(), 0.0);
}

}  // namespace
}  // namespace magimu
