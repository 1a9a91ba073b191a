// SPDX-License-Identifier: BSD-3-Clause
// Data that come window by window must end where all of them at once do.
#include "solvers/incremental_qr.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  EXPECT_LT((Q - P).cwiseAbs().cwiseQuotient(P.diagonal().cwiseSqrt() *
                                             P.diagonal().cwiseSqrt().transpose())
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

}  // namespace
}  // namespace magimu
