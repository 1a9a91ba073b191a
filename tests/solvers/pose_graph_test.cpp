// SPDX-License-Identifier: BSD-3-Clause
// Rotation averaging on a pose graph that others made, with loops; the file is not part of the
// project.
#include <filesystem>

#include "tests/solvers/each_backend.h"
#include "tests/solvers/rotation_averaging.h"

namespace magimu {
namespace {

const std::string kSmallest = std::string(MAGIMU_DATA_DIR) + "/pose_graphs/tinyGrid3D.g2o";

class PublicPoseGraph : public test::EachBackend {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kSmallest)) {
      GTEST_SKIP() << "The pose graph " << kSmallest << " is not there.";
    }
    problem_ = g2o::rotation_averaging(g2o::read_file(kSmallest));
  }
  Result optimize(const Values& start, Backend backend) const {
    return LevenbergMarquardt(problem_.graph, test::with(backend)).optimize(start);
  }
  g2o::RotationAveraging problem_;
};
MAGIMU_TEST_EACH_BACKEND(PublicPoseGraph);

TEST_P(PublicPoseGraph, has_one_minimum_for_every_back_end_and_start) {
  const Result result = optimize(problem_.start, GetParam());
  ASSERT_TRUE(result.converged()) << result.message;
  EXPECT_LT(result.cost_final, 0.9 * result.cost_initial);
  EXPECT_LT(result.gradient_norm, 1e-5);
  const Result other = optimize(problem_.start, Backend::kEigen);
  EXPECT_NEAR(result.cost_final, other.cost_final, 1e-9 * other.cost_final);
  EXPECT_LT(test::sigmas_between(problem_.graph, other.values, result.values), 1e-5);
  test::RandomValue random(1);
  for (int i = 0; i < 10; ++i) {
    const VectorXd delta = test::random_delta(random, problem_.start.dim(), 0.2);
    const Result moved = optimize(test::moved(problem_.start, delta), GetParam());
    EXPECT_TRUE(moved.converged()) << moved.message;
    EXPECT_NEAR(moved.cost_final, result.cost_final, 1e-9 * result.cost_final);
    EXPECT_LT(test::sigmas_between(problem_.graph, result.values, moved.values), 1e-5);
  }
}

// Without a linearization: around the minimum the cost rises, and with the square of the distance.
TEST_P(PublicPoseGraph, the_cost_rises_quadratically_from_there_in_every_direction) {
  const Result result = optimize(problem_.start, GetParam());
  test::RandomValue random(2);
  for (int i = 0; i < 50; ++i) {
    const VectorXd d = test::random_delta(random, result.values.dim(), 1.0).normalized();
    const auto rise = [&](double h) {
      return problem_.graph.cost(test::moved(result.values, h * d)) - result.cost_final;
    };
    const double near = rise(1e-4), opposite = rise(-1e-4), twice = rise(2e-4);
    EXPECT_GT(near, 0.0);
    EXPECT_NEAR(opposite / near, 1.0, 1e-2);
    EXPECT_NEAR(twice / near, 4.0, 1e-2);
  }
}

TEST(G2oFile, says_what_is_wrong_and_where) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "g2o_test.g2o";
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    return g2o::read_file(path.string());
  };
  const auto fails = [](const std::string& what) {
    return ThrowsMessage<std::runtime_error>(HasSubstr(what));
  };
  const std::string vertex0 = "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1\n";
  const std::string vertex1 = "VERTEX_SE3:QUAT 1 1 2 3 0 0 0 1\n";
  // a turn by 90 degrees about z, with sigmas of 0.5, 0.2 and 0.1 rad
  const std::string edge =
      "EDGE_SE3:QUAT 0 1 1 2 3 0 0 0.70710678118654752 0.70710678118654752 "
      "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 4 0 0 25 0 100\n";
  EXPECT_THAT([&] { g2o::read_file(path.string() + ".absent"); }, fails("cannot be opened"));
  EXPECT_THAT([&] { read(""); }, fails("no vertices"));
  EXPECT_THAT([&] { read(vertex1); }, fails(":1: vertices must be numbered"));
  EXPECT_THAT([&] { read(vertex0 + "VERTEX_SE3:QUAT 1 2 3\n"); }, fails(":2: a position"));
  EXPECT_THAT([&] { read(vertex0 + "\n" + edge.substr(0, 80)); }, fails(":3: 21 numbers"));
  EXPECT_THAT([&] { read(vertex0 + edge); }, fails("not there"));
  const g2o::File file = read(vertex0 + vertex1 + edge);
  ASSERT_EQ(file.edges.size(), 1U);
  EXPECT_LT((file.edges[0].iRj * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-15);
  EXPECT_LT((file.edges[0].covariance.diagonal() - Vector3(0.25, 0.04, 0.01)).norm(), 1e-15);
  EXPECT_LT((g2o::spanning_tree(file)[1] * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-15);
  EXPECT_THAT([&] { g2o::spanning_tree(read(vertex0 + vertex1)); }, fails("not connected"));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace magimu
