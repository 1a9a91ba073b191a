// SPDX-License-Identifier: BSD-3-Clause
// Each back end against dense linear algebra.
#include "solvers/linear/linear_solver.h"

#include <Eigen/Dense>

#include "solvers/back_ends.h"
#include "solvers/linear/ordering.h"
#include "tests/solvers/each_backend.h"

namespace magimu {
namespace {

using test::dense_jacobian;

class LinearSolvers : public test::EachBackend {};
MAGIMU_TEST_EACH_BACKEND(LinearSolvers);

// The minimizer of |J S y + r|^2 + lambda |y|^2 by Householder QR of the dense stacked matrix.
VectorXd dense_minimizer(const LinearSystem& system, const VectorXd& scale, double lambda) {
  const Eigen::Index m = system.rows(), n = system.cols();
  MatrixXd A = MatrixXd::Zero(m + n, n);
  A.topRows(m) = dense_jacobian(system) * scale.asDiagonal();
  A.bottomRows(n).diagonal().setConstant(std::sqrt(lambda));
  VectorXd b = VectorXd::Zero(m + n);
  b.head(m) = -system.residual();
  return A.colPivHouseholderQr().solve(b);
}

TEST_P(LinearSolvers, steps_agree_with_dense_orthogonal_factorization) {
  for (const Problem& p : {test::chain_with_globals(1, 40), test::pose_graph(2, 40)}) {
    LinearSystem system(p.graph, p.start);
    const auto solver = make_linear_solver(GetParam());
    // Damped and not, in turn, on one solver; and again after the numbers changed.
    for (const Values& at : {p.start, p.truth}) {
      system.linearize(at);
      const VectorXd scale = column_scale(system);
      for (const double lambda : {0.0, 1e-3, 10.0, 0.0, 1e-9}) {
        ASSERT_TRUE(solver->factorize(system, scale, lambda));
        const VectorXd y = solver->solve(system, scale);
        const VectorXd expected = dense_minimizer(system, scale, lambda);
        EXPECT_LT((y - expected).norm(), 1e-8 * expected.norm()) << "lambda " << lambda;
      }
    }
  }
}

TEST_P(LinearSolvers, solves_the_normal_equations_for_many_right_hand_sides) {
  const Problem p = test::chain_with_globals(3, 30);
  LinearSystem system(p.graph, p.start);
  system.linearize(p.start);
  const VectorXd scale = column_scale(system);
  const MatrixXd JS = dense_jacobian(system) * scale.asDiagonal();
  const auto solver = make_linear_solver(GetParam());
  for (const double lambda : {0.0, 0.1}) {
    ASSERT_TRUE(solver->factorize(system, scale, lambda));
    const MatrixXd H =
        JS.transpose() * JS + lambda * MatrixXd::Identity(system.cols(), system.cols());
    const MatrixXd B = MatrixXd::Identity(system.cols(), 5);
    const MatrixXd expected = H.llt().solve(B);
    EXPECT_LT((solver->solve_normal(B) - expected).norm(), 1e-8 * expected.norm());
  }
}

TEST_P(LinearSolvers, refuses_a_singular_matrix_and_serves_again_once_damped) {
  const Problem p = test::pose_graph(4, 30, /*prior=*/false);
  LinearSystem system(p.graph, p.start);
  system.linearize(p.start);
  const VectorXd scale = column_scale(system);
  const auto solver = make_linear_solver(GetParam());
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(solver->factorize(system, scale, 0.0));
    ASSERT_TRUE(solver->factorize(system, scale, 1e-3));
    const VectorXd expected = dense_minimizer(system, scale, 1e-3);
    EXPECT_LT((solver->solve(system, scale) - expected).norm(), 1e-9 * expected.norm());
  }
}

// Rounding leaves a pivot that should be zero at some 1e-16, of either sign.
TEST_P(LinearSolvers, refuses_a_singular_matrix_whatever_its_rounding_errors) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Problem p = test::pose_graph(seed, 2 + int(seed % 20), /*prior=*/false);
    LinearSystem system(p.graph, p.start);
    system.linearize(p.start);
    EXPECT_FALSE(make_linear_solver(GetParam())->factorize(system, column_scale(system), 0.0))
        << "seed " << seed;
  }
}

TEST(LinearSolver, column_scale_makes_columns_of_unit_norm) {
  const Problem p = test::chain_with_globals(5, 20);
  LinearSystem system(p.graph, p.start);
  system.linearize(p.start);
  const MatrixXd JS = dense_jacobian(system) * column_scale(system).asDiagonal();
  for (Eigen::Index c = 0; c < JS.cols(); ++c) EXPECT_NEAR(JS.col(c).norm(), 1.0, 1e-14);
}

TEST(LinearSolver, globals_are_the_columns_that_all_samples_share) {
  const Problem p = test::chain_with_globals(6, 200);
  const LinearSystem system(p.graph, p.start);
  const std::vector<int> global = global_columns(system);
  for (const Values::Slot& slot : p.start.slots()) {
    for (int c = 0; c < slot.type.tangent(); ++c) {
      EXPECT_EQ(global[std::size_t(slot.tangent + c)], slot.key.symbol == 'R' ? 0 : 1)
          << to_string(slot.key);
    }
  }
}

TEST(LinearSolver, a_back_end_that_was_not_built_in_says_how_to_get_it) {
  const auto built = test::backends();
  EXPECT_THAT(built, testing::Contains(Backend::kEigen));
  EXPECT_NE(make_linear_solver(Backend::kAuto), nullptr);
  for (const Backend b : {Backend::kCholmod, Backend::kSpqr}) {
    if (std::find(built.begin(), built.end(), b) != built.end()) continue;
    EXPECT_THAT([&] { make_linear_solver(b); },
                testing::ThrowsMessage<std::invalid_argument>(
                    testing::HasSubstr("-DMAGIMU_WITH_SUITESPARSE=ON")));
  }
}

}  // namespace
}  // namespace magimu
