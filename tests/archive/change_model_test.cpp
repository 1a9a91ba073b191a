// SPDX-License-Identifier: BSD-3-Clause
#include "archive/change_model.h"

#include <gmock/gmock.h>

#include <Eigen/Dense>

#include "tests/archive/change_problems.h"

namespace magimu {
namespace {

using test::draw_device;
using test::DrawnDevice;

// log p of all recordings by one large matrix: the measurements y_k = x_k + e_k, with x_k jointly
// Gaussian. The recordings' own normalization is left out, as in ChangeModel.
double dense_log_evidence(const ChangeProblem& p, const std::vector<DeviceChange>& changes) {
  const Eigen::Index n = p.prior.vector.size(), count = Eigen::Index(p.recordings.size());
  MatrixXd C = MatrixXd::Zero(n * count, n * count), A = C;  // covariance of all x; information
  VectorXd h(n * count);
  const MatrixXd P0 = p.prior.information.inverse();
  const double length = p.time.back() - p.time.front();
  for (Eigen::Index i = 0; i < count; ++i) {
    A.block(n * i, n * i, n, n) = p.recordings[std::size_t(i)].information;
    h.segment(n * i, n) = p.recordings[std::size_t(i)].vector;
    for (Eigen::Index j = 0; j < count; ++j) {
      MatrixXd S = P0;
      for (const DeviceChange& c : changes) {
        const ParameterGroup& g = p.groups[c.group];
        const MatrixXd W = c.size * c.size * g.G * g.W * g.G.transpose();
        const auto at = Eigen::Index(c.at);
        const double ti = (p.time[std::size_t(i)] - p.time[0]) / length - 0.5,
                     tj = (p.time[std::size_t(j)] - p.time[0]) / length - 0.5;
        if (c.kind == ChangeKind::kStep && i >= at && j >= at) S += W;
        if (c.kind == ChangeKind::kWalk) {
          S += W * (ti < tj ? ti + 0.5 : tj + 0.5) * double(count - 1);
        }
        if (c.kind == ChangeKind::kTrend) S += W * ti * tj;
        if (c.kind == ChangeKind::kScatter && i == j) S += W;
      }
      C.block(n * i, n * j, n, n) = S;
    }
  }
  // E over x of exp(-1/2 x'A x + h'x).
  const MatrixXd M = MatrixXd::Identity(n * count, n * count) + C * A;
  const double log_det = M.partialPivLu().matrixLU().diagonal().array().abs().log().sum();
  return 0.5 * h.dot(M.partialPivLu().solve(C * h)) - 0.5 * log_det;
}

double own_constant(const ChangeProblem& p) {  // of the prior, which ChangeModel leaves out
  return 0.5 * p.prior.information.ldlt().vectorD().array().log().sum();
}

class EvidenceOf : public testing::TestWithParam<std::vector<DeviceChange>> {};

TEST_P(EvidenceOf, changes_agrees_with_the_dense_covariance_of_all_recordings) {
  DrawnDevice device = draw_device(std::vector<VectorXd>(5, VectorXd::Ones(6)), 3);
  device.problem.prior.information = 0.1 * MatrixXd::Identity(6, 6);
  device.problem.time = {0.0, 1.0, 1.5, 4.0, 6.0};
  const ChangeModel model(device.problem, GetParam());
  EXPECT_NEAR(model.log_evidence() + own_constant(device.problem),
              dense_log_evidence(device.problem, GetParam()), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    ChangeModel, EvidenceOf,
    testing::Values(std::vector<DeviceChange>{},
                    std::vector<DeviceChange>{{ChangeKind::kStep, 0, 2, 3.0}},
                    std::vector<DeviceChange>{{ChangeKind::kWalk, 1, 0, 0.7}},
                    std::vector<DeviceChange>{{ChangeKind::kTrend, 0, 0, 5.0}},
                    std::vector<DeviceChange>{{ChangeKind::kScatter, 1, 0, 2.0}},
                    std::vector<DeviceChange>{{ChangeKind::kStep, 0, 4, 8.0},
                                              {ChangeKind::kTrend, 1, 0, 2.0},
                                              {ChangeKind::kScatter, 0, 0, 1.0}}));

TEST(ChangeModel, evidence_with_a_step_more_is_that_of_the_model_with_it) {
  const DrawnDevice device = draw_device(std::vector<VectorXd>(6, VectorXd::Ones(6)), 5);
  const ChangeModel model(device.problem, {{ChangeKind::kTrend, 1, 0, 2.0}});
  const std::vector<double> all = model.log_evidence_with_step(0, 4.0);
  ASSERT_EQ(all.size(), 5u);
  for (std::size_t k = 1; k < 6; ++k) {
    const ChangeModel with(device.problem,
                           {{ChangeKind::kTrend, 1, 0, 2.0}, {ChangeKind::kStep, 0, k, 4.0}});
    EXPECT_NEAR(all[k - 1], with.log_evidence(), 1e-7) << k;
  }
}

TEST(ChangeModel, smoothed_parameters_are_the_weighted_mean_where_nothing_changes) {
  const DrawnDevice device = draw_device(std::vector<VectorXd>(4, VectorXd::Ones(6)), 8);
  MatrixXd A = device.problem.prior.information;
  VectorXd h = VectorXd::Zero(6);
  for (const Gaussian& g : device.problem.recordings) {
    A += g.information;
    h += g.vector;
  }
  for (const Gaussian& g : ChangeModel(device.problem, {}).smoothed()) {
    EXPECT_LT((g.mean() - A.llt().solve(h)).norm(), 1e-9);
    EXPECT_LT((g.covariance() - A.inverse()).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace magimu
