// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/marginals.h"

#include <Eigen/Dense>

#include "tests/solvers/each_backend.h"

namespace magimu {
namespace {

class MarginalCovariance : public test::EachBackend {};
MAGIMU_TEST_EACH_BACKEND(MarginalCovariance);

MatrixXd dense_covariance(const FactorGraph& graph, const Values& values) {
  LinearSystem system(graph, values);
  system.linearize(values);
  const MatrixXd J = test::dense_jacobian(system);
  // By the inverse of the QR's triangle: the condition number is not squared.
  const MatrixXd Q_R = J.householderQr().matrixQR();
  const MatrixXd inverse = MatrixXd(Q_R.topRows(J.cols()))
                               .triangularView<Eigen::Upper>()
                               .solve(MatrixXd::Identity(J.cols(), J.cols()));
  return inverse * inverse.transpose();
}

MatrixXd block(const MatrixXd& S, const Values& values, Key a, Key b) {
  const Values::Slot &i = values.slot(a), &j = values.slot(b);
  return S.block(i.tangent, j.tangent, i.type.tangent(), j.type.tangent());
}

TEST_P(MarginalCovariance, covariance_is_the_dense_inverse) {
  for (const Problem& p : {test::chain_with_globals(1, 40), test::pose_graph(2, 40)}) {
    const MatrixXd expected = dense_covariance(p.graph, p.truth);
    const Marginals marginals(p.graph, p.truth, GetParam());
    EXPECT_TRUE(marginals.null_space().empty());
    for (const Values::Slot& slot : p.truth.slots()) {
      const MatrixXd S = marginals.covariance(slot.key);
      const MatrixXd block_expected = block(expected, p.truth, slot.key, slot.key);
      EXPECT_LT((S - block_expected).norm(), 1e-9 * block_expected.norm()) << to_string(slot.key);
      EXPECT_EQ(S, S.transpose());
    }
  }
}

TEST_P(MarginalCovariance, joint_covariance_has_the_blocks_in_the_order_asked_for) {
  const Problem p = test::chain_with_globals(3, 40);
  const MatrixXd dense = dense_covariance(p.graph, p.truth);
  const Marginals marginals(p.graph, p.truth, GetParam());
  const std::vector<Key> keys = {key::dip, R(3), key::distortion, key::mag_bias};
  const MatrixXd S = marginals.covariance(keys);
  ASSERT_EQ(S.rows(), 1 + 3 + 9 + 3);
  int row = 0;
  for (const Key a : keys) {
    int col = 0;
    for (const Key b : keys) {
      const MatrixXd expected = block(dense, p.truth, a, b);
      EXPECT_LT((S.block(row, col, expected.rows(), expected.cols()) - expected).norm(),
                1e-9 * (1e-6 + expected.norm()))
          << to_string(a) << ", " << to_string(b);
      col += int(expected.cols());
    }
    row += p.truth.slot(a).type.tangent();
  }
}

TEST_P(MarginalCovariance, a_prior_alone_gives_back_its_covariance) {
  Matrix3 S;
  S << 4.0, 1.0, 0.5, 1.0, 2.0, 0.3, 0.5, 0.3, 1.0;
  FactorGraph graph;
  Values v;
  v.insert(key::mag_bias, Vector3(1.0, 2.0, 3.0));
  v.insert(R(0), Rot3());
  graph.add(PriorFactor<Vector3>(key::mag_bias, Vector3(1.0, 2.0, 3.0), Noise<3>::full(S)));
  graph.add(PriorFactor<Rot3>(R(0), Rot3(), Noise<3>::full(1e-4 * S)));
  const Marginals marginals(graph, v, GetParam());
  EXPECT_LT((marginals.covariance(key::mag_bias) - S).norm(), 1e-12);
  EXPECT_LT((marginals.covariance(R(0)) - 1e-4 * S).norm(), 1e-16);
}

// Errors of the estimate over simulated data sets, in units of the reported covariance.
TEST(Marginals, errors_are_as_large_as_the_covariance_says) {
  constexpr int kRuns = 60;
  double sum = 0.0;
  int dof = 0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    const Problem p = test::chain_with_globals(100 + seed, 40);
    const Result result = LevenbergMarquardt(p.graph).optimize(p.truth);
    const std::vector<Key> keys = {key::gyr_bias, key::distortion, key::mag_bias, key::dip};
    const MatrixXd S = Marginals(p.graph, result.values).covariance(keys);
    const VectorXd all = result.values.local_coordinates(p.truth);
    VectorXd e(S.rows());
    int row = 0;
    for (const Key k : keys) {
      const Values::Slot& slot = p.truth.slot(k);
      e.segment(row, slot.type.tangent()) = all.segment(slot.tangent, slot.type.tangent());
      row += slot.type.tangent();
    }
    sum += e.dot(S.llt().solve(e));
    dof += int(e.size());
  }
  EXPECT_NEAR(sum, dof, 4.0 * std::sqrt(2.0 * dof));
}

TEST_P(MarginalCovariance, an_undetermined_variable_is_an_error_that_names_the_direction) {
  FactorGraph graph;
  graph.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return x + y; }));
  const Marginals marginals(graph, scalars({1.0, -1.0}), GetParam());
  ASSERT_EQ(marginals.null_space().size(), 1U);
  EXPECT_THAT([&] { (void)marginals.covariance(x_key(0)); },
              ThrowsMessage<std::domain_error>(
                  AllOf(HasSubstr("undetermined"), HasSubstr("x0"), HasSubstr("x1"))));
  EXPECT_THROW((void)marginals.covariance(Key{'q', 1}), std::invalid_argument);
}

// A pose graph that turns freely next to a chain: the chain's covariance must not notice.
TEST_P(MarginalCovariance, an_unrelated_free_direction_does_not_disturb_the_others) {
  Problem p = test::chain_with_globals(4, 40);
  const MatrixXd expected = dense_covariance(p.graph, p.truth);
  const Values chain = p.truth;
  const Problem loose = test::pose_graph(5, 12, /*prior=*/false);
  const auto key_of = [](Key k) { return Key{'L', k.index}; };
  for (int i = 0; i < 12; ++i) p.truth.insert(key_of(R(i)), loose.truth.at<Rot3>(R(i)));
  for (const RelativeRotationFactor& f : loose.graph.factors<RelativeRotationFactor>()) {
    p.graph.add(
        RelativeRotationFactor(key_of(f.keys()[0]), key_of(f.keys()[1]), Rot3(), f.noise()));
  }
  const Marginals marginals(p.graph, p.truth, GetParam());
  EXPECT_EQ(marginals.null_space().size(), 3U);
  for (const Key k : {R(0), R(39), key::distortion, key::mag_bias, key::gyr_bias, key::dip}) {
    const MatrixXd S = block(expected, chain, k, k);
    EXPECT_LT((marginals.covariance(k) - S).norm(), 1e-6 * S.norm()) << to_string(k);
  }
  EXPECT_THAT(
      [&] {
        (void)marginals.covariance({key::dip, key_of(R(3))});
      },
      ThrowsMessage<std::domain_error>(HasSubstr("L0 to L11")));
}

// Many free directions: more than find_null_space lists by default.
TEST_P(MarginalCovariance, many_free_directions_are_all_found) {
  constexpr int kPairs = 20;
  FactorGraph graph;
  Values v;
  v.insert(Key{'k', 0}, 1.0);
  graph.add(residual(
      Key{'k', 0}, [](auto x) { return x - 1.0; }, Noise<1>::isotropic(0.5)));
  for (int i = 0; i < kPairs; ++i) {
    v.insert(x_key(2 * i), 1.0);
    v.insert(x_key(2 * i + 1), -1.0);
    graph.add(residual(x_key(2 * i), x_key(2 * i + 1), [](auto x, auto y) { return x + y; }));
  }
  const Marginals marginals(graph, v, GetParam());
  EXPECT_EQ(marginals.null_space().size(), std::size_t(kPairs));
  EXPECT_NEAR(marginals.covariance(Key{'k', 0})(0, 0), 0.25, 1e-9);
  for (int i = 0; i < 2 * kPairs; ++i) {
    EXPECT_THROW((void)marginals.covariance(x_key(i)), std::domain_error) << i;
    EXPECT_NEAR(marginals.determined_covariance({x_key(i)})(0, 0), 0.25, 1e-6) << i;
  }
}

// Along x + y the sum is known to a sigma of 1; across it nothing moves.
TEST_P(MarginalCovariance, determined_covariance_is_the_pseudo_inverse_in_scaled_columns) {
  FactorGraph graph;
  graph.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return x + y; }));
  const Marginals marginals(graph, scalars({1.0, -1.0}), GetParam());
  const MatrixXd S = marginals.determined_covariance({x_key(0), x_key(1)});
  EXPECT_LT((S - MatrixXd::Constant(2, 2, 0.25)).norm(), 1e-9);
}

}  // namespace
}  // namespace magimu
