// SPDX-License-Identifier: BSD-3-Clause
// Data that leave a direction free: it is found, counted, named, and never divided by.
#include <Eigen/QR>

#include "graph/numerical_error.h"
#include "solvers/back_ends.h"
#include "solvers/marginals.h"
#include "solvers/null_space.h"
#include "tests/solvers/each_backend.h"

namespace magimu {
namespace {

class SingularGraph : public test::EachBackend {
 protected:
  std::vector<NullDirection> null_space(const FactorGraph& graph, const Values& values,
                                        int max_directions = 8) const {
    LinearSystem system(graph, values);
    system.linearize(values);
    const auto solver = make_linear_solver(GetParam());
    return find_null_space(system, *solver, 3e-7, max_directions);
  }
};
MAGIMU_TEST_EACH_BACKEND(SingularGraph);

// The directions found span exactly the columns of `expected`.
void expect_span(const std::vector<NullDirection>& found, const MatrixXd& expected) {
  ASSERT_EQ(Eigen::Index(found.size()), expected.cols());
  MatrixXd given(expected.rows(), expected.cols());
  for (std::size_t i = 0; i < found.size(); ++i) {
    given.col(Eigen::Index(i)) = found[i].direction.normalized();
    EXPECT_LT(found[i].singular_value, 1e-7);
  }
  const auto qr = expected.householderQr();
  const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(expected.rows(), expected.cols());
  EXPECT_LT((given - Q * (Q.transpose() * given)).norm(), 1e-6);
  EXPECT_EQ(given.colPivHouseholderQr().rank(), expected.cols());
}

// Turning all poses of columns first, first + 3, ... alike from the left changes no measurement.
MatrixXd common_rotation(int cols, int first, int last) {
  MatrixXd N = MatrixXd::Zero(cols, 3);
  for (int c = first; c < last; ++c) N(c, c % 3) = 1.0;
  return N;
}

TEST_P(SingularGraph, a_pose_graph_without_a_prior_turns_as_a_whole) {
  for (const int n : {2, 5, 40, 600}) {
    const Problem p = test::pose_graph(1, n, /*prior=*/false);
    expect_span(null_space(p.graph, p.start), common_rotation(3 * n, 0, 3 * n));
    const Result result = GaussNewton(p.graph, options()).optimize(p.start);
    EXPECT_EQ(result.reason, StopReason::kSingular) << n << ": " << result.message;
    EXPECT_THAT(result.message, HasSubstr("R0"));
    EXPECT_THAT(result.message,
                HasSubstr("R" + std::to_string(n - 1) + " all by the same turn (3 free axes)."));
    EXPECT_THAT(result.message, Not(HasSubstr("; and")));
    try {
      Marginals(p.graph, p.start, GetParam()).covariance(R(0));
      FAIL() << "a covariance of what is undetermined";
    } catch (const NumericalError& error) {
      EXPECT_THAT(error.what(), HasSubstr("all by the same turn (3 free axes)"));
    }
  }
}

TEST_P(SingularGraph, a_prior_removes_it) {
  for (const int n : {2, 40, 600}) {
    const Problem p = test::pose_graph(1, n);
    EXPECT_TRUE(null_space(p.graph, p.start).empty());
    EXPECT_TRUE(GaussNewton(p.graph, options()).optimize(p.start).converged());
  }
}

TEST_P(SingularGraph, a_long_chain_without_loops_is_regular_with_a_prior_only) {
  constexpr int kPoses = 3000;
  FactorGraph graph;
  Values v;
  test::RandomValue random(2);
  for (int i = 0; i < kPoses; ++i) v.insert(R(i), random.rotation());
  const Noise<3> noise = Noise<3>::isotropic(0.01);
  for (int i = 0; i + 1 < kPoses; ++i) {
    graph.add(RelativeRotationFactor(R(i), R(i + 1),
                                     v.at<Rot3>(R(i)).inverse() * v.at<Rot3>(R(i + 1)), noise));
  }
  EXPECT_EQ(null_space(graph, v).size(), 3U);
  EXPECT_EQ(GaussNewton(graph, options()).optimize(v).reason, StopReason::kSingular);
  graph.add(PriorFactor<Rot3>(R(0), v.at<Rot3>(R(0)), noise));
  EXPECT_EQ(null_space(graph, v).size(), 0U);
  EXPECT_TRUE(GaussNewton(graph, options()).optimize(v).converged());
}

TEST_P(SingularGraph, a_sum_alone_leaves_the_difference_free) {
  FactorGraph graph;  // 2 x + 0.001 y = 1, whatever the scales of the columns
  graph.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return 2.0 * x + 1e-3 * y - 1.0; }));
  graph.add(residual(x_key(2), [](auto x) { return x - 4.0; }));
  const Values start = scalars({2.0, 3.0, 1.0});
  expect_span(null_space(graph, start), Vector3(-1e-3, 2.0, 0.0));
  const Result result = GaussNewton(graph, options()).optimize(start);
  EXPECT_EQ(result.reason, StopReason::kSingular);
  EXPECT_THAT(result.message, HasSubstr("x1 along (1)"));
  EXPECT_THAT(result.message, Not(HasSubstr("x2")));
}

TEST_P(SingularGraph, a_variable_without_influence_is_named_alone) {
  FactorGraph graph;
  graph.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return x - 2.0 + 0.0 * y; }));
  const Values start = scalars({2.0, 3.0});
  expect_span(null_space(graph, start), Vector2(0.0, 1.0));
  const Result result = GaussNewton(graph, options()).optimize(start);
  EXPECT_EQ(result.reason, StopReason::kSingular);
  EXPECT_THAT(result.message, HasSubstr("x1 along"));
  EXPECT_THAT(result.message, Not(HasSubstr("x0")));
}

TEST_P(SingularGraph, separate_pose_graphs_have_a_null_space_each) {
  constexpr int kPoses = 8;
  for (const int graphs : {2, 3}) {
    Problem all;
    MatrixXd expected(3 * kPoses * graphs, 3 * graphs);
    for (int g = 0; g < graphs; ++g) {
      const Problem one = test::pose_graph(unsigned(3 + g), kPoses, /*prior=*/false);
      const auto key = [g](Key k) { return R(int(k.index) + g * kPoses); };
      for (int i = 0; i < kPoses; ++i) all.start.insert(key(R(i)), one.start.at<Rot3>(R(i)));
      for (const RelativeRotationFactor& f : one.graph.factors<RelativeRotationFactor>()) {
        all.graph.add(
            RelativeRotationFactor(key(f.keys()[0]), key(f.keys()[1]), Rot3(), f.noise()));
      }
      expected.middleCols(3 * g, 3) =
          common_rotation(int(expected.rows()), 3 * kPoses * g, 3 * kPoses * (g + 1));
    }
    expect_span(null_space(all.graph, all.start, 16), expected);
    EXPECT_EQ(null_space(all.graph, all.start).size(), std::size_t(graphs == 2 ? 6 : 8));
  }
}

TEST_P(SingularGraph, what_is_weakly_determined_is_not_called_free) {
  for (const double weight : {1e-2, 1e-4, 3e-6}) {
    FactorGraph graph;
    graph.add(residual(x_key(0), x_key(1), [](auto x, auto y) { return x + y - 1.0; }));
    graph.add(residual(x_key(0), x_key(1), [weight](auto x, auto y) { return weight * (x - y); }));
    const Values start = scalars({2.0, 3.0});
    EXPECT_TRUE(null_space(graph, start).empty()) << weight;
    const Result result = GaussNewton(graph, options()).optimize(start);
    EXPECT_TRUE(result.converged()) << weight << ": " << result.message;
    EXPECT_NEAR(result.values.at<double>(x_key(0)), 0.5, 1e-9);
  }
}

TEST_P(SingularGraph, a_well_posed_calibration_has_no_null_space) {
  const Problem p = test::chain_with_globals(4, 60);
  EXPECT_TRUE(null_space(p.graph, p.truth).empty());
}

// A sensor that keeps its orientation cannot tell the distortion from the bias.
TEST_P(SingularGraph, a_sensor_at_rest_leaves_the_distortion_free) {
  FactorGraph graph;
  Values v;
  v.insert(R(0), Rot3());
  v.insert(key::distortion, Matrix3(50.0 * Matrix3::Identity()));
  v.insert(key::mag_bias, Vector3(1.0, 2.0, 3.0));
  v.insert(key::dip, 1.0);
  graph.add(PriorFactor<Rot3>(R(0), Rot3(), Noise<3>::isotropic(0.01)));
  graph.add(PriorFactor<double>(key::dip, 1.0, Noise<1>::isotropic(0.01)));
  const Vector3 mag =
      magnetometer_model(Rot3(), v.at<Matrix3>(key::distortion), v.at<Vector3>(key::mag_bias), 1.0);
  for (int i = 0; i < 5; ++i) {
    graph.add(MagnetometerFactor(R(0), key::distortion, key::mag_bias, key::dip, mag,
                                 Noise<3>::isotropic(0.3)));
  }
  // 12 unknowns of distortion and bias, 3 measured combinations: D east is not seen at all.
  EXPECT_EQ(null_space(graph, v, 20).size(), 9U);
  const Result result = GaussNewton(graph, options()).optimize(v);
  EXPECT_EQ(result.reason, StopReason::kSingular);
  EXPECT_THAT(result.message, HasSubstr("D0"));
}

TEST_P(SingularGraph, levenberg_marquardt_still_reduces_the_cost) {
  const Problem free = test::pose_graph(5, 40, /*prior=*/false);
  const Problem fixed = test::pose_graph(5, 40);
  const Result best = LevenbergMarquardt(fixed.graph).optimize(fixed.start);
  OptimizerOptions undamped = options();
  undamped.initial_damping = 0.0;
  for (const OptimizerOptions& o : {options(), undamped}) {
    const Result result = LevenbergMarquardt(free.graph, o).optimize(free.start);
    EXPECT_TRUE(result.converged()) << result.message;
    EXPECT_LT(result.cost_final, 0.1 * result.cost_initial);
    EXPECT_LE(result.cost_final, best.cost_final * (1.0 + 1e-8));
    for (const double number : result.values.data()) EXPECT_TRUE(std::isfinite(number));
    for (const IterationRecord& record : result.trace) {
      EXPECT_TRUE(std::isfinite(record.cost) && std::isfinite(record.step_norm));
    }
  }
}

TEST(Describe, names_a_trajectory_as_a_range_and_few_variables_one_by_one) {
  Values v;
  for (int i = 0; i < 10; ++i) v.insert(R(i), Rot3());
  v.insert(x_key(0), 1.0);
  v.insert(Key{'v', 2}, Vector3(0.0, 0.0, 0.0));
  VectorXd d = VectorXd::Zero(v.dim());
  d.head<30>().setConstant(0.1);
  d[30] = 2.0;
  const NullDirection direction{0.0, d};
  EXPECT_EQ(describe(direction, v), "x0 along (0.964), R0 to R9");
  EXPECT_EQ(describe(direction, v, [](Key k) { return std::string("the ") + k.symbol; }),
            "the x along (0.964), the R");  // a range whose ends have one name needs it once
  EXPECT_EQ(describe(direction, v, [](Key k) { return "node " + std::to_string(k.index); }),
            "node 0 along (0.964), node 0 to node 9");
}

TEST(Describe, leaves_out_rounding) {
  Values v;
  v.insert(Key{'v', 2}, Vector3(0.0, 0.0, 0.0));
  v.insert(x_key(0), 1.0);
  VectorXd d(4);
  d << 3e-16, -2.0, 0.0, 1e-14;
  EXPECT_EQ(describe({0.0, d}, v), "v2 along (0, -1, 0)");
}

}  // namespace
}  // namespace magimu
