// SPDX-License-Identifier: BSD-3-Clause
// The evidence of a process beside a chain, against the density of the residuals from their dense
// covariance.
#include "solvers/chain/process_chain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "graph/decompositions.h"
#include "tests/solvers/example_graphs.h"

namespace magimu {
namespace {

int node_of(Key key) { return key.symbol == R(0).symbol ? int(key.index) : -1; }

// A chain of nodes; each row sees the process somewhere between two nodes of the grid.
struct Example {
  Example(int nodes, std::vector<int> grid_nodes)
      : problem(test::chain_with_globals(7, nodes)), random(3) {
    problem.graph.add(
        PriorFactor<Vector3>(key::acc_bias, Vector3(0.1, 0, 0), Noise<3>::isotropic(0.3)));
    system.emplace(problem.graph, problem.start);
    system->linearize(problem.start);
    grid.node = std::move(grid_nodes);
    for (const int n : grid.node) {
      grid.time.push_back(0.1 * n);
      grid.begins.push_back(n == 0);
    }
    rows.jacobian.assign(std::size_t(system->rows()), Vector3::Zero());
    rows.weight.assign(std::size_t(system->rows()), 0.0);
    on_grid = MatrixXd::Zero(system->rows(), kProcess * Eigen::Index(grid.node.size()));
    const MatrixXd J = test::dense_jacobian(*system);
    for (int i = 0; i < system->rows(); ++i) {
      int first = -1;
      for (int n = nodes - 1; n >= 0; --n) {
        if (J.middleCols(problem.start.slot(R(n)).tangent, 3).row(i).norm() > 0.0) first = n;
      }
      if (first < 0) continue;
      std::size_t j = 0;
      while (j + 1 < grid.node.size() && grid.node[j + 1] <= first) ++j;
      const auto r = std::size_t(i);
      rows.jacobian[r] = random.vector3(2.0);
      rows.weight[r] = first == nodes - 1 ? 0.0 : std::abs(std::sin(double(i)));
      const Eigen::Index at = kProcess * Eigen::Index(j);
      on_grid.row(i).segment(at, kProcess) += (1.0 - rows.weight[r]) * rows.jacobian[r];
      if (rows.weight[r] > 0.0) {
        on_grid.row(i).segment(at + kProcess, kProcess) += rows.weight[r] * rows.jacobian[r];
      }
    }
  }
  ProcessChain chain() const { return {*system, problem.start, node_of, grid, rows}; }
  MatrixXd process_covariance(double size, double memory) const {
    const auto n = Eigen::Index(grid.node.size());
    MatrixXd P = MatrixXd::Zero(kProcess * n, kProcess * n);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        const double apart = std::abs(grid.time[std::size_t(i)] - grid.time[std::size_t(j)]);
        P.block<kProcess, kProcess>(kProcess * i, kProcess * j) =
            size * size * std::exp(-apart / memory) * Matrix3::Identity();
      }
    }
    return P;
  }

  test::Problem problem;
  test::RandomValue random;
  std::optional<LinearSystem> system;
  ProcessGrid grid;
  ProcessRows rows;
  MatrixXd on_grid;  // what each row sees
};

double log_det(const MatrixXd& A) {
  return 2.0 * A.llt().matrixLLT().diagonal().array().log().sum();
}

// Residuals N(0, I + B P B') with everything else flat.
double dense_log_density(const Example& e, double size, double memory) {
  const MatrixXd J = test::dense_jacobian(*e.system);
  const MatrixXd B = e.on_grid;
  const MatrixXd S = MatrixXd::Identity(J.rows(), J.rows()) +
                     B * e.process_covariance(size, memory) * B.transpose();
  const Eigen::LLT<MatrixXd> llt(S);
  const MatrixXd W = llt.matrixL().solve(J);
  const VectorXd w = llt.matrixL().solve(e.system->residual());
  const MatrixXd A = W.transpose() * W;
  const VectorXd g = W.transpose() * w;
  return -0.5 * (w.squaredNorm() - g.dot(A.llt().solve(g)) + log_det(S) + log_det(A));
}

std::vector<int> every(int step, int nodes) {
  std::vector<int> out;
  for (int n = 0; n + 1 < nodes; n += step) out.push_back(n);
  out.push_back(nodes - 1);
  return out;
}

TEST(ProcessChain, evidence_is_the_density_of_the_residuals_from_their_dense_covariance) {
  constexpr int kNodes = 20;
  for (const int step : {1, 2, 7}) {
    const Example e(kNodes, every(step, kNodes));
    const ProcessChain chain = e.chain();
    for (const double size : {0.0, 1e-3, 0.1, 3.0}) {
      for (const double memory : {0.05, 1.0, 300.0}) {
        const double expected = dense_log_density(e, size, memory);
        EXPECT_NEAR(chain.evidence(size, memory).log_density(), expected,
                    1e-6 * std::max(1.0, std::abs(expected)))
            << "nodes every " << step << ", size " << size << ", memory " << memory;
      }
    }
  }
}

// Further globals with a prior, what rows see of their node, and rows that are left out.
TEST(ProcessChain, more_globals_have_a_prior_and_rows_left_out_say_nothing) {
  constexpr int kNodes = 20, kMore = 4;
  constexpr double kSize = 0.4, kMemory = 0.8;
  for (const int step : {1, 3}) {
    Example e(kNodes, every(step, kNodes));
    const Eigen::Index n = e.system->rows();
    MatrixXd J = test::dense_jacobian(*e.system);
    MatrixXd all = MatrixXd::Zero(n + kMore, J.cols() + kMore);
    VectorXd r = VectorXd::Zero(n + kMore);
    r.head(n) = e.system->residual();
    e.rows.more_globals = MatrixXd::Zero(n, kMore);
    e.rows.more_node.assign(std::size_t(n), Vector3::Zero());
    e.rows.more_residual.assign(std::size_t(n), 0.0);
    e.rows.scale.assign(std::size_t(n), 1.0);
    for (Eigen::Index i = 0; i < n; ++i) {
      if (e.rows.jacobian[std::size_t(i)].norm() == 0.0) continue;
      int first = kNodes - 1;
      for (int k = kNodes - 1; k >= 0; --k) {
        if (J.middleCols(e.problem.start.slot(R(k)).tangent, 3).row(i).norm() > 0.0) first = k;
      }
      const auto at = std::size_t(i);
      e.rows.more_node[at] = e.random.vector3(1.0);
      e.rows.more_residual[at] = 0.1 * std::sin(double(i));
      e.rows.scale[at] = i % 5 == 0 ? 0.0 : 0.7;
      for (int c = 0; c < kMore; ++c) e.rows.more_globals(i, c) = std::cos(double(3 * i + c));
      J.row(i).segment<3>(e.problem.start.slot(R(first)).tangent) += e.rows.more_node[at];
      r[i] += e.rows.more_residual[at];
    }
    all.topLeftCorner(n, J.cols()) = J;
    all.topRightCorner(n, kMore) = e.rows.more_globals;
    all.bottomRightCorner(kMore, kMore).setIdentity();
    MatrixXd B = MatrixXd::Zero(n + kMore, e.on_grid.cols());
    B.topRows(n) = e.on_grid;
    for (Eigen::Index i = 0; i < n; ++i) {
      all.row(i) *= e.rows.scale[std::size_t(i)];
      B.row(i) *= e.rows.scale[std::size_t(i)];
      r[i] *= e.rows.scale[std::size_t(i)];
    }
    const MatrixXd S = MatrixXd::Identity(n + kMore, n + kMore) +
                       B * e.process_covariance(kSize, kMemory) * B.transpose();
    const Eigen::LLT<MatrixXd> llt(S);
    const MatrixXd W = llt.matrixL().solve(all);
    const VectorXd w = llt.matrixL().solve(r);
    const MatrixXd A = W.transpose() * W;
    const VectorXd g = W.transpose() * w;
    const VectorXd x = -A.llt().solve(g);
    const double expected = -0.5 * (w.squaredNorm() + g.dot(x) + log_det(S) + log_det(A));
    EXPECT_NEAR(e.chain().evidence(kSize, kMemory).log_density(), expected,
                1e-6 * std::abs(expected));
    const SmoothedProcess smoothed = e.chain().smooth(kSize, kMemory, false);
    EXPECT_LT((smoothed.globals.tail(kMore) - x.tail(kMore)).norm(), 1e-6);
    for (std::size_t j = 0; j < e.grid.node.size(); ++j) {
      const int at = e.problem.start.slot(R(e.grid.node[j])).tangent;
      EXPECT_LT((smoothed.node[j] - x.segment<3>(at)).norm(), 1e-6);
    }
  }
}

TEST(ProcessChain, size_to_zero_is_the_chain_without_a_process) {
  const Example e(60, every(1, 60));
  const ProcessChain chain = e.chain();
  const double without = chain.evidence(0.0, 1.0).log_density();
  EXPECT_NEAR(chain.evidence(0.0, 50.0).log_density(), without, 1e-7);
  EXPECT_NEAR(chain.evidence(1e-6, 3.0).log_density(), without, 1e-4);
}

TEST(ProcessChain, smoothed_process_is_the_conditional_mean_and_covariance) {
  constexpr int kNodes = 20;
  const double size = 0.5, memory = 0.7;
  for (const int step : {1, 3}) {
    const Example e(kNodes, every(step, kNodes));
    const SmoothedProcess smoothed = e.chain().smooth(size, memory);
    // Of [nodes and globals | process].
    const MatrixXd J = test::dense_jacobian(*e.system);
    MatrixXd all(J.rows(), J.cols() + e.on_grid.cols());
    all << J, e.on_grid;
    MatrixXd A = all.transpose() * all;
    A.bottomRightCorner(e.on_grid.cols(), e.on_grid.cols()) +=
        e.process_covariance(size, memory).inverse();
    const MatrixXd covariance = A.inverse();
    const VectorXd x = -covariance * (all.transpose() * e.system->residual());
    for (std::size_t j = 0; j < e.grid.node.size(); ++j) {
      const Eigen::Index at = J.cols() + kProcess * Eigen::Index(j);
      EXPECT_LT((smoothed.mean[j] - x.segment(at, 3)).norm(), 1e-6);
      EXPECT_LT((smoothed.sigma[j].cwiseAbs2() - covariance.diagonal().segment(at, 3)).norm(),
                1e-6);
    }
    const int bias = e.problem.start.slot(key::acc_bias).tangent;
    EXPECT_EQ(smoothed.globals.size(), 19);
    EXPECT_NEAR(smoothed.globals[0], x[bias], 1e-6);
  }
}

TEST(ProcessChain, two_chains_have_processes_that_do_not_know_of_each_other) {
  constexpr int kNodes = 20;
  Example e(kNodes, every(1, kNodes));
  // Cut between the nodes 9 and 10: the link goes.
  FactorGraph graph;
  for (const auto& f : e.problem.graph.factors<AccelerometerFactor>()) graph.add(f);
  for (const auto& f : e.problem.graph.factors<MagnetometerFactor>()) graph.add(f);
  for (const auto& f : e.problem.graph.factors<GyroscopeFactor>()) {
    if (f.keys()[0].index != 9) graph.add(f);
  }
  LinearSystem system(graph, e.problem.start);
  system.linearize(e.problem.start);
  e.grid.begins[10] = true;
  ProcessRows rows;
  rows.jacobian.assign(std::size_t(system.rows()), Vector3(1.0, 0.5, -0.3));
  rows.weight.assign(std::size_t(system.rows()), 0.0);
  const double together =
      ProcessChain(system, e.problem.start, node_of, e.grid, rows).evidence(0.3, 1e9).log_density();
  MatrixXd B = MatrixXd::Zero(system.rows(), 2 * kProcess);
  const MatrixXd J = test::dense_jacobian(system);
  for (int i = 0; i < J.rows(); ++i) {
    bool late = true;
    for (int n = 0; n < 10; ++n) {
      if (J.middleCols(e.problem.start.slot(R(n)).tangent, 3).row(i).norm() > 0.0) late = false;
    }
    B.row(i).segment(late ? 3 : 0, 3) = rows.jacobian[std::size_t(i)].transpose();
  }
  const MatrixXd S = MatrixXd::Identity(J.rows(), J.rows()) + 0.09 * B * B.transpose();
  const Eigen::LLT<MatrixXd> llt(S);
  const MatrixXd W = llt.matrixL().solve(J);
  const VectorXd w = llt.matrixL().solve(system.residual());
  const MatrixXd A = W.transpose() * W;
  const VectorXd g = W.transpose() * w;
  const double expected =
      -0.5 * (w.squaredNorm() - g.dot(A.llt().solve(g)) + log_det(S) + log_det(A));
  EXPECT_NEAR(together, expected, 1e-3);  // a memory of 1e9 s is not for ever
}

}  // namespace
}  // namespace magimu
