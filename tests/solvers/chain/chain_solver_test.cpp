// SPDX-License-Identifier: BSD-3-Clause
// The chain back end against the general ones, and that it is chosen where the graph has its form.
#include "solvers/chain/chain_solver.h"

#include <gmock/gmock.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <Eigen/Dense>

#include "solvers/back_ends.h"
#include "solvers/levenberg_marquardt.h"
#include "solvers/marginals.h"
#include "solvers/null_space.h"
#include "tests/solvers/example_graphs.h"

namespace magimu {
namespace {

using test::Problem;
using test::RandomValue;

// r = A x + B y + C z + b, with random A, B, C: couples two nodes, or a node and globals.
template <int N, int M, int G, int Rows>
class LinearFactor : public Factor<Rows, Vec<double, N>, Vec<double, M>, Vec<double, G>> {
 public:
  LinearFactor(Key x, Key y, Key z, RandomValue& random)
      : Factor<Rows, Vec<double, N>, Vec<double, M>, Vec<double, G>>({x, y, z}, Noise<Rows>{}) {
    const auto number = [&] { return random.number(1.0); };
    A_ = decltype(A_)::NullaryExpr(number);
    B_ = decltype(B_)::NullaryExpr(number);
    C_ = decltype(C_)::NullaryExpr(number);
    b_ = decltype(b_)::NullaryExpr(number);
  }
  template <class T>
  Vec<T, Rows> residual(const Vec<T, N>& x, const Vec<T, M>& y, const Vec<T, G>& z) const {
    // Written out: products of every combination of sizes would compile for a minute.
    Vec<T, Rows> r;
    for (int i = 0; i < Rows; ++i) {
      r[i] = b_[i];
      for (int j = 0; j < N; ++j) r[i] += A_(i, j) * x[j];
      for (int j = 0; j < M; ++j) r[i] += B_(i, j) * y[j];
      for (int j = 0; j < G; ++j) r[i] += C_(i, j) * z[j];
    }
    return r;
  }

 private:
  Eigen::Matrix<double, Rows, N> A_;
  Eigen::Matrix<double, Rows, M> B_;
  Eigen::Matrix<double, Rows, G> C_;
  Vec<double, Rows> b_;
};

constexpr Key a_key(int i) { return {'a', std::uint32_t(i)}; }
constexpr Key c_key(int i) { return {'c', std::uint32_t(i)}; }

// Adds a chain of n nodes, each of one variable of size N, that all share the globals c0 and c1.
template <int N>
void add_chain(Problem& p, int first, int n, RandomValue& random) {
  for (int i = 0; i < n; ++i) p.start.insert(a_key(first + i), Vec<double, N>::Zero().eval());
  for (int i = 0; i + 1 < n; ++i) {
    const Key x = a_key(first + i), y = a_key(first + i + 1);
    p.graph.add(LinearFactor<N, N, 5, N>(x, y, c_key(0), random));
    p.graph.add(LinearFactor<N, N, 2, N>(y, x, c_key(1), random));  // backward in time
  }
}
template <int N>
Problem linear_chain(unsigned seed, const std::vector<int>& lengths) {
  RandomValue random(seed);
  Problem p;
  p.start.insert(c_key(0), Vec<double, 5>::Zero().eval());
  int first = 0;
  for (const int n : lengths) {
    add_chain<N>(p, first, n, random);
    if (first == 0) p.start.insert(c_key(1), Vec<double, 2>::Zero().eval());  // amid the nodes
    first += n;
  }
  return p;
}

// Nodes of sizes 1, 2 and 3 with steps over one node: levels of several variables.
Problem irregular_chain(unsigned seed, int n) {
  RandomValue random(seed);
  Problem p;
  const auto node = [](int i) { return a_key((i * 7) % 1000); };  // not in the order of time
  for (int i = 0; i < n; ++i) {
    if (i % 3 == 0) p.start.insert(node(i), Vec<double, 1>::Zero().eval());
    if (i % 3 == 1) p.start.insert(node(i), Vec<double, 2>::Zero().eval());
    if (i % 3 == 2) p.start.insert(node(i), Vec<double, 3>::Zero().eval());
  }
  p.start.insert(c_key(0), Vec<double, 5>::Zero().eval());
  for (int i = 0; i + 4 < n; i += 3) {
    p.graph.add(LinearFactor<1, 2, 5, 3>(node(i), node(i + 1), c_key(0), random));
    p.graph.add(LinearFactor<2, 3, 5, 4>(node(i + 1), node(i + 2), c_key(0), random));
    p.graph.add(LinearFactor<3, 1, 5, 3>(node(i + 2), node(i + 3), c_key(0), random));
    p.graph.add(LinearFactor<1, 3, 5, 2>(node(i), node(i + 2), c_key(0), random));
    p.graph.add(LinearFactor<2, 2, 5, 2>(node(i + 1), node(i + 4), c_key(0), random));
  }
  return p;
}

// A square grid of rotations: its levels are wider than a chain's, whatever the start.
Problem grid(unsigned seed, int n) {
  RandomValue random(seed);
  Problem p;
  for (int i = 0; i < n * n; ++i) p.start.insert(R(i), random.rotation());
  const auto join = [&](int i, int j) {
    p.graph.add(RelativeRotationFactor(R(i), R(j), random.rotation(), Noise<3>::isotropic(0.1)));
  };
  p.graph.add(PriorFactor<Rot3>(R(0), random.rotation(), Noise<3>::isotropic(0.1)));
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j + 1 < n; ++j) {
      join(i * n + j, i * n + j + 1);
      join(j * n + i, (j + 1) * n + i);
    }
  }
  return p;
}

LinearSystem linearized(const Problem& p) {
  LinearSystem system(p.graph, p.start);
  system.linearize(p.start);
  return system;
}

void expect_agreement(const Problem& p) {
  const LinearSystem system = linearized(p);
  const VectorXd scale = column_scale(system);
  const auto chain = make_linear_solver(Backend::kChain);
  std::vector<Backend> others = test::backends();
  std::erase(others, Backend::kChain);
  RandomValue random(1);
  const MatrixXd B = MatrixXd::NullaryExpr(system.cols(), 19, [&] { return random.number(1.0); });
  const MatrixXd JS = test::dense_jacobian(system) * scale.asDiagonal();
  const MatrixXd H = JS.transpose() * JS;
  for (const double lambda : {0.0, 1e-3, 10.0, 0.0}) {
    ASSERT_TRUE(chain->factorize(system, scale, lambda));
    const VectorXd y = chain->solve(system, scale);
    const MatrixXd X = chain->solve_normal(B);
    const Eigen::LLT<MatrixXd> dense(H + lambda * MatrixXd::Identity(H.rows(), H.cols()));
    EXPECT_LT((X - dense.solve(B)).norm(), 1e-8 * X.norm()) << "lambda " << lambda;
    EXPECT_LT((X.col(0) - chain->solve_normal(B.col(0))).norm(), 1e-12 * X.col(0).norm());
    for (const Backend other : others) {
      const auto solver = make_linear_solver(other);
      ASSERT_TRUE(solver->factorize(system, scale, lambda)) << to_string(other);
      const VectorXd expected = solver->solve(system, scale);
      EXPECT_LT((y - expected).norm(), 1e-8 * expected.norm()) << to_string(other) << ' ' << lambda;
    }
  }
}

TEST(ChainSolver, agrees_with_the_other_back_ends_on_chains_of_3_and_of_9_columns_a_node) {
  expect_agreement(test::chain_with_globals(1, 200));
  expect_agreement(linear_chain<3>(2, {150}));
  expect_agreement(linear_chain<9>(3, {100}));
}

TEST(ChainSolver, agrees_where_two_chains_share_globals) {
  expect_agreement(linear_chain<3>(4, {70, 131}));    // both eliminated from two ends
  expect_agreement(linear_chain<9>(5, {90, 3, 20}));  // only the first
}

TEST(ChainSolver, agrees_where_levels_are_irregular) { expect_agreement(irregular_chain(6, 302)); }

TEST(ChainSolver, agrees_without_globals) {
  RandomValue random(7);
  Problem p;
  const Noise<3> noise = Noise<3>::isotropic(0.1);
  for (int i = 0; i < 100; ++i) p.start.insert(R(i), random.rotation());
  for (int i = 0; i < 100; ++i) {
    p.graph.add(PriorFactor<Rot3>(R(i), p.start.at<Rot3>(R(i)), noise));
    if (i % 10 == 9) continue;  // ten chains
    p.graph.add(RelativeRotationFactor(R(i), R(i + 1), random.rotation(), noise));
  }
  expect_agreement(p);
}

TEST(ChainSolver, agrees_on_a_graph_of_few_nodes) {
  for (const int n : {2, 3, 5}) {
    Problem p = test::pose_graph(8, n);
    expect_agreement(p);
  }
}

TEST(ChainSolver, is_chosen_for_chains_and_left_for_graphs_with_many_loops) {
  const Problem chain = test::chain_with_globals(9, 200), loops = grid(10, 30);
  for (const Problem* p : {&chain, &loops}) {
    const bool is_chain = p == &chain;
    const LinearSystem system = linearized(*p);
    const VectorXd scale = column_scale(system);
    EXPECT_EQ(make_chain_solver(system) != nullptr, is_chain);
    const auto chosen = make_linear_solver(Backend::kAuto);
    ASSERT_TRUE(chosen->factorize(system, scale, 0.0));
    const auto expected = make_linear_solver(is_chain ? Backend::kChain : test::backends().front());
    ASSERT_TRUE(expected->factorize(system, scale, 0.0));
    EXPECT_EQ(chosen->solve(system, scale), expected->solve(system, scale));  // the same bits
  }
}

TEST(ChainSolver, a_graph_of_another_form_says_so) {
  const LinearSystem system = linearized(grid(11, 30));
  const VectorXd scale = column_scale(system);
  EXPECT_THAT([&] { make_linear_solver(Backend::kChain)->factorize(system, scale, 0.0); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("kAuto")));
}

// A chain of relative rotations: free to turn as a whole unless there is a prior.
Problem rotations(int n, bool prior) {
  RandomValue random(12);
  Problem p;
  const Noise<3> noise = Noise<3>::isotropic(0.01);
  for (int i = 0; i < n; ++i) p.start.insert(R(i), random.rotation());
  for (int i = 0; i + 1 < n; ++i) {
    const Rot3 step = p.start.at<Rot3>(R(i)).inverse() * p.start.at<Rot3>(R(i + 1));
    p.graph.add(RelativeRotationFactor(R(i), R(i + 1), step, noise));
  }
  if (prior) p.graph.add(PriorFactor<Rot3>(R(n / 3), p.start.at<Rot3>(R(n / 3)), noise));
  return p;
}

TEST(ChainSolver, refuses_a_singular_matrix_and_serves_again_once_damped) {
  for (const int n : {2, 40, 400, 3000, 20000}) {
    const LinearSystem system = linearized(rotations(n, false));
    const VectorXd scale = column_scale(system);
    const auto solver = make_linear_solver(Backend::kChain);
    for (int i = 0; i < 2; ++i) {
      EXPECT_FALSE(solver->factorize(system, scale, 0.0)) << n;
      EXPECT_TRUE(solver->factorize(system, scale, 1e-3)) << n;
    }
  }
}

TEST(ChainSolver, refuses_a_long_chain_of_wide_nodes_that_is_free_to_move) {
  RandomValue random(16);
  Problem p;
  for (int i = 0; i < 2000; ++i) p.start.insert(a_key(i), Vec<double, 9>::Zero().eval());
  p.start.insert(c_key(0), Vec<double, 5>::Zero().eval());
  for (int i = 0; i + 1 < 2000; ++i) {
    p.graph.add(LinearFactor<9, 9, 5, 9>(a_key(i), a_key(i + 1), c_key(0), random));
  }
  const LinearSystem system = linearized(p);
  const VectorXd scale = column_scale(system);
  EXPECT_FALSE(make_linear_solver(Backend::kChain)->factorize(system, scale, 0.0));
}

TEST(ChainSolver, refuses_globals_without_influence) {
  RandomValue random(13);
  Problem p = linear_chain<3>(13, {100});
  p.start.insert(c_key(9), Vec<double, 5>::Zero().eval());
  p.graph.add(LinearFactor<3, 3, 5, 1>(a_key(3), a_key(4), c_key(9), random));  // 5 from one row
  const LinearSystem system = linearized(p);
  const VectorXd scale = column_scale(system);
  const auto solver = make_linear_solver(Backend::kChain);
  EXPECT_FALSE(solver->factorize(system, scale, 0.0));
  EXPECT_TRUE(solver->factorize(system, scale, 1e-6));
}

TEST(ChainSolver, null_space_of_a_chain_is_its_common_rotation) {
  for (const int n : {5, 600, 3000}) {
    for (const bool prior : {false, true}) {
      const Problem p = rotations(n, prior);
      const LinearSystem system = linearized(p);
      const auto solver = make_linear_solver(Backend::kChain);
      const auto null = find_null_space(system, *solver, 3e-7, 8);
      ASSERT_EQ(null.size(), prior ? 0U : 3U) << n;
      for (const NullDirection& d : null) {
        const Vector3 turn = d.direction.head<3>();
        for (int i = 0; i < n; ++i) {
          EXPECT_LT((d.direction.segment<3>(3 * i) - turn).norm(), 1e-6 * d.direction.norm());
        }
      }
    }
  }
}

TEST(ChainSolver, marginals_and_optimum_agree_with_the_other_back_ends) {
  const Problem p = test::chain_with_globals(14, 300);
  const auto fit = [&](Backend backend) {
    OptimizerOptions options;
    options.backend = backend;
    return LevenbergMarquardt(p.graph, options).optimize(p.start);
  };
  const Result chain = fit(Backend::kChain);
  ASSERT_TRUE(chain.converged());
  const Backend other = test::backends().front();
  EXPECT_LT(test::sigmas_between(p.graph, chain.values, fit(other).values), 1e-4);
  const MatrixXd expected = Marginals(p.graph, chain.values, other).covariance(key::distortion);
  const MatrixXd P = Marginals(p.graph, chain.values, Backend::kChain).covariance(key::distortion);
  EXPECT_LT((P - expected).norm(), 1e-7 * expected.norm());
}

TEST(ChainSolver, gives_the_same_bits_for_every_number_of_threads) {
  const Problem p = test::chain_with_globals(15, 1500);
  const auto with_threads = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(threads));
    tbb::task_arena arena(threads);
    return arena.execute([&] {
      const LinearSystem system = linearized(p);
      const VectorXd scale = column_scale(system);
      const auto solver = make_linear_solver(Backend::kChain);
      EXPECT_TRUE(solver->factorize(system, scale, 1e-6));
      MatrixXd X(system.cols(), 21);
      X.col(0) = solver->solve(system, scale);
      X.rightCols(20) = solver->solve_normal(MatrixXd::Identity(system.cols(), 20));
      return X;
    });
  };
  const MatrixXd one = with_threads(1);
  EXPECT_EQ(one, with_threads(2));
  EXPECT_EQ(one, with_threads(5));
}

}  // namespace
}  // namespace magimu
