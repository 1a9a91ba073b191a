// SPDX-License-Identifier: BSD-3-Clause
// Factors extended by a linear part in further variables: as good as factors written for them.
#include "graph/extended_batch.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <random>

#include "tests/graph/dense.h"

namespace magimu {
namespace {

constexpr Key kTurn{'x', 0}, kBias{'b', 0};
Key theta_key(int i) { return {'e', std::uint32_t(i)}; }

// R' v + bias - z.
class DirectionFactor : public Factor<3, Rot3, Vector3> {
 public:
  DirectionFactor(const Vector3& v, const Vector3& z, const Noise<3>& noise)
      : Factor({kTurn, kBias}, noise), v_(v), z_(z) {}
  template <class T>
  Vec3<T> residual(const Rot3T<T>& R, const Vec3<T>& bias) const {
    return R.unrotate(Vec3<T>(v_.template cast<T>())) + bias - z_.template cast<T>();
  }

 private:
  Vector3 v_, z_;
};

// The same, less G (theta - at), written out.
class WrittenOut : public Factor<3, Rot3, Vector3, double, double> {
 public:
  WrittenOut(const DirectionFactor& plain, const Mat<double, 3, 2>& G, const Vector2& at,
             const Noise<3>& noise)
      : Factor({kTurn, kBias, theta_key(0), theta_key(1)}, noise), plain_(plain), G_(G), at_(at) {}
  template <class T>
  Vec3<T> residual(const Rot3T<T>& R, const Vec3<T>& bias, const T& a, const T& b) const {
    const Vec3<T> first = G_.col(0).template cast<T>() * (a - at_[0]);
    const Vec3<T> second = G_.col(1).template cast<T>() * (b - at_[1]);
    return plain_.residual(R, bias) - first - second;
  }

 private:
  DirectionFactor plain_;
  Mat<double, 3, 2> G_;
  Vector2 at_;
};

struct ExtendedProblem {
  FactorGraph extended, written_out;
  Values values;
};

ExtendedProblem make_problem(const Noise<3>& noise, bool on_demand = false) {
  std::mt19937 engine(2);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3(normal(engine), normal(engine), normal(engine)); };
  const Vector2 at(0.3, -0.2);
  ExtendedProblem p;
  auto batch = std::make_unique<ExtendedBatch<DirectionFactor>>(
      std::vector<Key>{theta_key(0), theta_key(1)}, VectorXd(at));
  std::vector<std::function<ExtendedBatch<DirectionFactor>::Gain()>> gains;
  for (int i = 0; i < 12; ++i) {
    const DirectionFactor factor(vector(), vector(), noise);
    Mat<double, 3, 2> G;
    G << vector(), vector();
    if (on_demand) {
      batch->add_without_gain(factor);
    } else {
      batch->add(factor, G);
    }
    gains.push_back([G]() -> ExtendedBatch<DirectionFactor>::Gain { return G; });
    p.written_out.add(WrittenOut(factor, G, at, noise));
  }
  if (on_demand) batch->find_gains_with(std::move(gains));
  p.extended.add_batch(std::move(batch));
  p.values.insert(kTurn, Rot3::Exp(Vector3(0.3, -0.5, 0.8)));
  p.values.insert(kBias, Vector3(0.1, 0.2, -0.1));
  p.values.insert(theta_key(0), 0.5);
  p.values.insert(theta_key(1), 0.1);
  return p;
}

Noise<3> correlated_noise() {
  Matrix3 S;
  S << 2.0, 0.3, 0.1, 0.3, 1.0, -0.2, 0.1, -0.2, 0.5;
  return Noise<3>::full(S);
}

Values shifted(const Values& values, int column, double step) {
  VectorXd delta = VectorXd::Zero(values.dim());
  delta[column] = step;
  return values.retract({delta.data(), std::size_t(delta.size())});
}

TEST(ExtendedBatch, jacobian_is_that_of_its_residuals) {
  const ExtendedProblem p = make_problem(correlated_noise());
  LinearSystem system(p.extended, p.values);
  system.linearize(p.values);
  EXPECT_LT((system.residual() - system.whitened_residuals(p.values)).norm(), 1e-14);
  const MatrixXd J = test::dense_jacobian(system);
  for (int c = 0; c < J.cols(); ++c) {
    const VectorXd numerical = (system.whitened_residuals(shifted(p.values, c, 1e-5)) -
                                system.whitened_residuals(shifted(p.values, c, -1e-5))) /
                               2e-5;
    EXPECT_LT((J.col(c) - numerical).norm(), 1e-8) << c;
  }
}

TEST(ExtendedBatch, equals_a_factor_written_out) {
  for (const Noise<3>& noise : {correlated_noise(), correlated_noise().with_loss(Loss::huber()),
                                correlated_noise().with_loss(Loss::tukey(3.0))}) {
    const ExtendedProblem p = make_problem(noise);
    LinearSystem a(p.extended, p.values), b(p.written_out, p.values);
    EXPECT_NEAR(a.linearize(p.values), b.linearize(p.values), 1e-12);
    EXPECT_NEAR(a.cost(p.values), b.cost(p.values), 1e-12);
    EXPECT_LT((a.residual() - b.residual()).norm(), 1e-12);
    EXPECT_LT((test::dense_jacobian(a) - test::dense_jacobian(b)).norm(), 1e-12);
  }
}

TEST(ExtendedBatch, gains_found_on_demand_are_the_same_bits) {
  const ExtendedProblem kept = make_problem(correlated_noise());
  const ExtendedProblem found = make_problem(correlated_noise(), true);
  LinearSystem a(kept.extended, kept.values), b(found.extended, found.values);
  EXPECT_EQ(a.linearize(kept.values), b.linearize(found.values));
  EXPECT_EQ(a.cost(kept.values), b.cost(found.values));
  EXPECT_EQ(a.residual(), b.residual());
  EXPECT_EQ(test::dense_jacobian(a), test::dense_jacobian(b));
  EXPECT_EQ(found.extended.batches().front()->lane_text(Isa::kBaseline).linearize, nullptr);
}

TEST(ExtendedBatch, gradient_under_a_robust_loss_is_that_of_the_cost) {
  const ExtendedProblem p = make_problem(correlated_noise().with_loss(Loss::cauchy()));
  LinearSystem system(p.extended, p.values);
  system.linearize(p.values);
  const VectorXd gradient = system.gradient();
  for (int c = 0; c < gradient.size(); ++c) {
    const double numerical = (p.extended.cost(shifted(p.values, c, 1e-5)) -
                              p.extended.cost(shifted(p.values, c, -1e-5))) /
                             2e-5;
    EXPECT_NEAR(gradient[c], numerical, 1e-7) << c;
  }
}

TEST(ExtendedBatch, finds_the_solution_of_a_factor_written_out) {
  const ExtendedProblem p = make_problem(correlated_noise());
  const auto solve = [&](const FactorGraph& graph) {
    Values values = p.values;
    for (int i = 0; i < 30; ++i) {
      LinearSystem system(graph, values);
      system.linearize(values);
      const VectorXd step =
          -test::dense_jacobian(system).householderQr().solve(system.residual()).eval();
      values = values.retract({step.data(), std::size_t(step.size())});
    }
    return values;
  };
  EXPECT_LT(solve(p.extended).local_coordinates(solve(p.written_out)).norm(), 1e-9);
}

TEST(ExtendedBatch, copies_with_its_graph) {
  auto p = std::make_unique<ExtendedProblem>(make_problem(correlated_noise()));
  const FactorGraph copy = p->extended;
  const double cost = p->extended.cost(p->values);
  const Values values = p->values;
  p.reset();
  EXPECT_EQ(copy.cost(values), cost);
  EXPECT_EQ(copy.batches().front()->columns(), 8);
  EXPECT_EQ(copy.batches().front()->keys(3).back(), theta_key(1));
}

struct OfOneVector : Factor<3, Vector3> {
  explicit OfOneVector(Key key) : Factor({key}, Noise<3>::isotropic(1.0)) {}
  template <class T>
  Vec3<T> residual(const Vec3<T>& x) const {
    return x;
  }
};

TEST(ExtendedBatch, that_names_a_variable_twice_is_refused_whichever_factor_it_is) {
  auto batch = std::make_unique<ExtendedBatch<OfOneVector>>(
      std::vector<Key>{theta_key(0), theta_key(1)}, VectorXd(VectorXd::Zero(2)));
  const auto gain = Eigen::Matrix<double, 3, 2>::Ones();
  batch->add(OfOneVector(theta_key(7)), gain);
  batch->add(OfOneVector(theta_key(1)), gain);
  FactorGraph graph;
  EXPECT_THROW(graph.add_batch(std::move(batch)), std::invalid_argument);
}

}  // namespace
}  // namespace magimu
