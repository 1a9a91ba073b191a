// SPDX-License-Identifier: BSD-3-Clause
#include "graph/factor_graph.h"

#include <gmock/gmock.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "tests/factors/jacobian_check.h"
#include "tests/graph/dense.h"

namespace magimu {
namespace {

using test::dense_jacobian;
using test::RandomValue;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr Key pose(int i) { return {'R', std::uint32_t(i)}; }
constexpr Key point(int i) { return {'p', std::uint32_t(i)}; }
constexpr Key kGain{'g', 0}, kSeeing{'M', 0};

// A user's factor with automatic Jacobians: a scaled distance between two points in the plane.
class Distance : public Factor<1, Vector2, Vector2, double> {
 public:
  Distance(Key a, Key b, Key gain, double distance, const Noise<1>& noise)
      : Factor({a, b, gain}, noise), distance_(distance) {}
  template <class T>
  Vec<T, 1> residual(const Vec<T, 2>& a, const Vec<T, 2>& b, const T& gain) const {
    using std::sqrt;
    const Vec<T, 2> d = a - b;
    return Vec<T, 1>(gain * sqrt(d.dot(d)) - distance_);
  }

 private:
  double distance_;
};

// One with analytic Jacobians, on a rotation and a matrix: r = M R' a - b.
class Seen : public Factor<2, Rot3, Mat<double, 2, 3>> {
 public:
  Seen(Key R, Key M, const Vector3& a, const Vector2& b, const Noise<2>& noise)
      : Factor({R, M}, noise), a_(a), b_(b) {}
  template <class T>
  Vec<T, 2> residual(const Rot3T<T>& R, const Mat<T, 2, 3>& M) const {
    return M * R.unrotate(Vec3<T>(a_.cast<T>())) - b_.cast<T>();
  }
  template <class T>
  Vec<T, 2> linearize(const Rot3T<T>& R, const Mat<T, 2, 3>& M, Mat<T, 2, 3>& J_R,
                      Mat<T, 2, 6>& J_M) const {
    const Vec3<T> seen = R.unrotate(Vec3<T>(a_.cast<T>()));
    J_R = M * R.matrix().transpose() * so3::hat(Vec3<T>(a_.cast<T>()));
    J_M.setZero();
    for (int j = 0; j < 3; ++j) J_M(0, 2 * j) = J_M(1, 2 * j + 1) = seen[j];
    return M * seen - b_.cast<T>();
  }

 private:
  Vector3 a_;
  Vector2 b_;
};

struct Problem {
  FactorGraph graph;
  Values values;
};

// Both kinds of factors, interleaved; noise of every shape, and the given loss.
Problem make_problem(unsigned seed, int n, Loss loss) {
  RandomValue random(seed);
  Problem p;
  p.values.insert(kSeeing, Mat<double, 2, 3>(random.matrix3().topRows<2>()));
  for (int i = 0; i < n; ++i) p.values.insert(pose(i), random.rotation());
  for (int i = 0; i < n; ++i) p.values.insert(point(i), Vector2(random.number(), random.number()));
  p.values.insert(kGain, 1.3);
  Mat<double, 2, 2> S;
  S << 0.5, 0.2, 0.2, 0.3;
  for (int i = 0; i < n; ++i) {
    p.graph.add(Seen(pose(i), kSeeing, random.vector3(), Vector2(random.number(), random.number()),
                     Noise<2>::full(S).with_loss(loss)));
    p.graph.add(Distance(point((i + 1) % n), point(i), kGain, random.number(),
                         Noise<1>::isotropic(0.4).with_loss(loss)));
    p.graph.add(Seen(pose((i + 1) % n), kSeeing, random.vector3(), Vector2(0.1, 0.2),
                     Noise<2>::diagonal(Vector2(0.5, 2.0)).with_loss(loss)));
  }
  return p;
}

Values moved(const Values& values, int column, double step) {
  VectorXd delta = VectorXd::Zero(values.dim());
  delta[column] = step;
  return values.retract({delta.data(), std::size_t(delta.size())});
}

const std::vector<Loss> kLosses = {Loss{}, Loss::huber(0.8), Loss::cauchy(0.9), Loss::tukey(3.0)};

TEST(FactorGraph, cost_is_half_the_sum_of_squared_whitened_residuals) {
  Values v;
  v.insert(point(0), Vector2(0.0, 0.0));
  v.insert(point(1), Vector2(3.0, 4.0));
  v.insert(kGain, 2.0);
  FactorGraph graph;
  graph.add(Distance(point(0), point(1), kGain, 9.0, Noise<1>::isotropic(0.5)));  // (10 - 9) / 0.5
  graph.add(Distance(point(1), point(0), kGain, 13.0, Noise<1>()));               // -3
  EXPECT_DOUBLE_EQ(graph.cost(v), 0.5 * (4.0 + 9.0));
  graph.add(Distance(point(0), point(1), kGain, 4.0, Noise<1>().with_loss(Loss::huber(2.0))));
  EXPECT_DOUBLE_EQ(graph.cost(v), 0.5 * (4.0 + 9.0 + 2.0 * 2.0 * 6.0 - 4.0));
  EXPECT_EQ(graph.size(), 3);
}

TEST(FactorGraph, keeps_the_order_of_factors_of_one_type) {
  const Problem p = make_problem(1, 4, {});
  EXPECT_EQ(p.graph.factors<Distance>().size(), 4U);
  EXPECT_EQ(p.graph.factors<Seen>().size(), 8U);
  EXPECT_EQ(p.graph.factors<Distance>()[2].keys()[1], point(2));
  EXPECT_EQ(p.graph.batches().size(), 2U);
  EXPECT_TRUE(FactorGraph().factors<Seen>().empty());
}

TEST(FactorGraph, a_copy_is_deep) {
  const Problem p = make_problem(2, 5, {});
  const double cost = p.graph.cost(p.values);
  FactorGraph copy = p.graph, assigned;
  assigned.add(Distance(point(0), point(1), kGain, 1.0, {}));
  assigned = p.graph;
  EXPECT_EQ(copy.cost(p.values), cost);
  EXPECT_EQ(assigned.cost(p.values), cost);
  copy.mutable_factors<Distance>().clear();
  copy.add(Seen(pose(0), kSeeing, Vector3(1.0, 0.0, 0.0), Vector2(9.0, 9.0), {}));
  assigned.mutable_factors<Seen>().pop_back();
  EXPECT_EQ(p.graph.size(), 15);
  EXPECT_EQ(p.graph.cost(p.values), cost);
  EXPECT_EQ(copy.size(), 11);
  EXPECT_EQ(assigned.size(), 14);
  const FactorGraph& self = assigned;
  assigned = self;
  EXPECT_EQ(assigned.size(), 14);
}

TEST(FactorGraph, a_moved_graph_still_finds_its_factors) {
  Problem p = make_problem(3, 5, {});
  const double cost = p.graph.cost(p.values);
  FactorGraph other = std::move(p.graph);
  EXPECT_EQ(other.cost(p.values), cost);
  EXPECT_EQ(other.factors<Seen>().size(), 10U);
}

TEST(FactorGraph, refuses_a_factor_that_names_a_variable_twice) {
  FactorGraph graph;
  EXPECT_THAT([&] { graph.add(Distance(point(3), point(3), kGain, 1.0, {})); },
              ThrowsMessage<std::invalid_argument>(AllOf(HasSubstr("p3"), HasSubstr("twice"))));
  EXPECT_EQ(graph.size(), 0);
}

TEST(LinearSystem, errors_name_the_variable) {
  FactorGraph graph;
  graph.add(Distance(point(0), point(1), kGain, 1.0, {}));
  const Vector2 zero(0.0, 0.0);
  Values missing, wrong_type, unused;
  missing.insert(point(0), zero), missing.insert(kGain, 1.0);
  EXPECT_THAT(
      [&] { LinearSystem(graph, missing); },
      ThrowsMessage<std::invalid_argument>(AllOf(HasSubstr("p1"), HasSubstr("not in Values"))));
  wrong_type.insert(point(0), zero), wrong_type.insert(point(1), Rot3());
  wrong_type.insert(kGain, 1.0);
  EXPECT_THAT([&] { LinearSystem(graph, wrong_type); },
              ThrowsMessage<std::invalid_argument>(
                  AllOf(HasSubstr("p1"), HasSubstr("Vector2"), HasSubstr("Rot3"))));
  unused.insert(point(0), zero), unused.insert(point(1), zero), unused.insert(kGain, 1.0);
  unused.insert(pose(8), Rot3());
  EXPECT_THAT([&] { LinearSystem(graph, unused); },
              ThrowsMessage<std::invalid_argument>(AllOf(HasSubstr("R8"), HasSubstr("no factor"))));
}

TEST(LinearSystem, jacobian_and_residual_agree_with_numerical_differentiation) {
  constexpr double kStep = 1e-5;
  const Problem p = make_problem(4, 6, {});
  LinearSystem system(p.graph, p.values);
  const double cost = system.linearize(p.values);
  EXPECT_DOUBLE_EQ(cost, 0.5 * system.residual().squaredNorm());
  EXPECT_DOUBLE_EQ(cost, system.cost(p.values));
  EXPECT_DOUBLE_EQ(cost, p.graph.cost(p.values));
  EXPECT_LT((system.residual() - system.whitened_residuals(p.values)).norm(), 1e-14);
  const MatrixXd J = dense_jacobian(system);
  ASSERT_EQ(J.cols(), p.values.dim());
  for (int c = 0; c < system.cols(); ++c) {
    const VectorXd numerical = (system.whitened_residuals(moved(p.values, c, kStep)) -
                                system.whitened_residuals(moved(p.values, c, -kStep))) /
                               (2.0 * kStep);
    EXPECT_LT((J.col(c) - numerical).cwiseAbs().maxCoeff(), 1e-8) << "column " << c;
  }
}

TEST(LinearSystem, gradient_is_that_of_the_cost_for_every_loss) {
  constexpr double kStep = 1e-5;
  for (const Loss& loss : kLosses) {
    const Problem p = make_problem(5, 6, loss);
    LinearSystem system(p.graph, p.values);
    EXPECT_NEAR(system.linearize(p.values), system.cost(p.values), 1e-12);
    const VectorXd gradient = system.gradient();
    for (int c = 0; c < system.cols(); ++c) {
      const double numerical =
          (system.cost(moved(p.values, c, kStep)) - system.cost(moved(p.values, c, -kStep))) /
          (2.0 * kStep);
      EXPECT_NEAR(gradient[c], numerical, 1e-7) << "loss " << int(loss.kind) << ", column " << c;
    }
  }
}

TEST(LinearSystem, a_loss_scales_rows_by_the_root_of_its_weight) {
  const Problem plain = make_problem(6, 6, {}), robust = make_problem(6, 6, Loss::cauchy(0.9));
  LinearSystem a(plain.graph, plain.values), b(robust.graph, robust.values);
  a.linearize(plain.values);
  b.linearize(robust.values);
  const VectorXd r = b.whitened_residuals(robust.values);
  EXPECT_LT((r - a.residual()).norm(), 1e-14);
  int row = 0;
  for (const auto& batch : robust.graph.batches()) {
    for (int i = 0; i < batch->size(); ++i, row += batch->rows()) {
      const double s = r.segment(row, batch->rows()).squaredNorm();
      const double root = std::sqrt(Loss::cauchy(0.9).weight(s));
      EXPECT_LT(root, 1.0);
      const MatrixXd expected = root * dense_jacobian(a).middleRows(row, batch->rows());
      EXPECT_LT((dense_jacobian(b).middleRows(row, batch->rows()) - expected).norm(), 1e-13);
      EXPECT_LT((b.residual() - root * r).segment(row, batch->rows()).norm(), 1e-13);
    }
  }
  EXPECT_EQ(row, b.rows());
}

TEST(LinearSystem, products_agree_with_the_dense_matrix) {
  const Problem p = make_problem(7, 6, Loss::huber(0.8));
  LinearSystem system(p.graph, p.values);
  system.linearize(p.values);
  const MatrixXd J = dense_jacobian(system);
  const VectorXd x = VectorXd::LinSpaced(system.cols(), -1.0, 2.0);
  EXPECT_LT((system.multiply(x) - J * x).norm(), 1e-12);
  EXPECT_LT((system.gradient() - J.transpose() * system.residual()).norm(), 1e-12);
  EXPECT_LT((system.squared_column_norms() - J.colwise().squaredNorm().transpose()).norm(), 1e-12);
}

TEST(LinearSystem, relinearizes_at_new_values_and_new_measurements) {
  Problem p = make_problem(8, 6, {});
  LinearSystem system(p.graph, p.values);
  system.linearize(p.values);
  const Values elsewhere = moved(moved(p.values, 2, 0.3), 11, -0.2);
  LinearSystem fresh(p.graph, elsewhere);
  EXPECT_EQ(system.linearize(elsewhere), fresh.linearize(elsewhere));
  EXPECT_EQ(dense_jacobian(system), dense_jacobian(fresh));
  p.graph.mutable_factors<Distance>()[0] =
      Distance(point(1), point(0), kGain, 100.0, Noise<1>::isotropic(0.1));
  EXPECT_GT(system.linearize(elsewhere), 1e5);
}

// Above the size of one task, so that several threads really share the work.
TEST(LinearSystem, has_the_same_bits_for_every_number_of_threads) {
  const Problem p = make_problem(9, 3000, Loss::huber(0.8));
  struct Numbers {
    double linearized, cost;
    std::vector<double> value;
    VectorXd residual;
  };
  const auto run = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(threads));
    tbb::task_arena arena(threads);
    return arena.execute([&] {
      LinearSystem system(p.graph, p.values);
      const double cost = system.linearize(p.values);
      return Numbers{cost, system.cost(p.values),
                     std::vector<double>(system.value().begin(), system.value().end()),
                     system.residual()};
    });
  };
  const Numbers one = run(1);
  for (const int threads : {2, 5, 8}) {
    const Numbers many = run(threads);
    EXPECT_EQ(one.linearized, many.linearized) << threads;
    EXPECT_EQ(one.cost, many.cost) << threads;
    EXPECT_EQ(one.value, many.value) << threads;
    EXPECT_EQ(one.residual, many.residual) << threads;
  }
}

}  // namespace
}  // namespace magimu
