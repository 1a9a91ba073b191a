// SPDX-License-Identifier: BSD-3-Clause
// The field model: free of curl and divergence, of the published form, and exactly transported.
#include "factors/field_basis.h"

#include <gtest/gtest.h>

#include <random>

#include "navigation/field_transport.h"
#include "recording/arrays/array_mat.h"

namespace magimu {
namespace {

class Dice {
 public:
  double number() { return uniform_(engine_); }
  Vector3 vector(double size = 1.0) { return size * Vector3(number(), number(), number()); }
  VectorXd numbers(int count) {
    return VectorXd::NullaryExpr(count, [&] { return number(); });
  }

 private:
  std::mt19937 engine_{7};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

TEST(FieldBasis, has_the_published_number_of_columns_and_they_are_independent) {
  for (int order = 1; order <= FieldBasis::kHighestOrder; ++order) {
    const FieldBasis basis(order);
    EXPECT_EQ(basis.size(), order * order + 4 * order + 3);
    Dice dice;
    std::vector<Vector3> points;
    for (int i = 0; i < 40; ++i) points.push_back(dice.vector());
    EXPECT_EQ(basis.at(points).colPivHouseholderQr().rank(), basis.size()) << order;
  }
}

TEST(FieldBasis, begins_with_the_gradients_of_z_y_x_yz_and_so_on) {
  const Vector3 r(0.3, -0.7, 1.1);
  const double x = r.x(), y = r.y(), z = r.z();
  Matrix3X expected(3, 8);
  expected.transpose() << 0, 0, 1, 0, 1, 0, 1, 0, 0,  // z, y, x
      0, z, y, 0, y, -z, z, 0, x, y, x, 0, x, 0, -z;  // yz, (y^2-z^2)/2, xz, xy, (x^2-z^2)/2
  Matrix3X phi = FieldBasis(2).at(r).leftCols(8);
  phi.col(4) /= 2.0;
  phi.col(7) /= 2.0;
  EXPECT_LT((phi - expected).cwiseAbs().maxCoeff(), 1e-15) << phi;
}

TEST(FieldBasis, every_column_is_free_of_curl_and_divergence) {
  Dice dice;
  for (int order = 1; order <= FieldBasis::kHighestOrder; ++order) {
    const FieldBasis basis(order);
    for (int i = 0; i < basis.size(); ++i) {
      const Matrix3 gradient = basis.gradient(VectorXd::Unit(basis.size(), i), dice.vector());
      EXPECT_NEAR(gradient.trace(), 0.0, 1e-12);
      EXPECT_LT((gradient - gradient.transpose()).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

TEST(FieldBasis, gradient_is_the_derivative_of_the_field) {
  Dice dice;
  for (int order = 1; order <= FieldBasis::kHighestOrder; ++order) {
    const FieldBasis basis(order);
    const VectorXd theta = dice.numbers(basis.size());
    const Vector3 r = dice.vector();
    const Matrix3 gradient = basis.gradient(theta, r);
    for (int i = 0; i < 3; ++i) {
      const Vector3 h = 1e-5 * Vector3::Unit(i);
      const Vector3 numerical = (basis.at(r + h) - basis.at(r - h)) * theta / 2e-5;
      EXPECT_LT((numerical - gradient.col(i)).cwiseAbs().maxCoeff(), 1e-7) << order;
    }
  }
}

TEST(FieldBasis, degree_of_a_column_is_how_it_scales) {
  Dice dice;
  const FieldBasis basis(4);
  const Vector3 r = dice.vector();
  const Matrix3X near = basis.at(r), far = basis.at(Vector3(2.0 * r));
  for (int i = 0; i < basis.size(); ++i) {
    const double scale = std::pow(2.0, FieldBasis::degree_of(i));
    EXPECT_LT((far.col(i) - scale * near.col(i)).norm(), 1e-12) << i;
  }
}

TEST(FieldBasis, a_plane_array_tells_the_coefficients_apart) {
  const std::vector<Vector3> board = published_array_layout();
  const double published[] = {14, 239, 4717};
  for (int order = 1; order <= 3; ++order) {
    const auto values = FieldBasis(order).at(board).jacobiSvd().singularValues();
    EXPECT_NEAR(values[0] / values[values.size() - 1] / published[order - 1], 1.0, 0.05) << order;
  }
}

TEST(FieldTransport, is_exact_at_random_places) {
  Dice dice;
  for (int order = 1; order <= FieldBasis::kHighestOrder; ++order) {
    const FieldTransport transport(order);
    const FieldBasis& basis = transport.basis();
    for (int trial = 0; trial < 20; ++trial) {
      const VectorXd theta = dice.numbers(basis.size());
      const Rot3 E = Rot3::Exp(dice.vector(2.0));
      const Vector3 d = dice.vector(0.5), r = dice.vector();
      const Vector3 here = E.unrotate(basis.at(Vector3(E * r + d)) * theta);
      const Vector3 there = basis.at(r) * transport.move(theta, E, d).theta;
      EXPECT_LT((here - there).cwiseAbs().maxCoeff(), 1e-10) << order;
    }
  }
}

TEST(FieldTransport, of_two_moves_is_one_of_both) {
  Dice dice;
  for (int order = 1; order <= FieldBasis::kHighestOrder; ++order) {
    const FieldTransport transport(order);
    const Rot3 E1 = Rot3::Exp(dice.vector()), E2 = Rot3::Exp(dice.vector());
    const Vector3 d1 = dice.vector(), d2 = dice.vector();
    const MatrixXd both = transport.matrix(E1 * E2, E1 * d2 + d1);
    const MatrixXd apart = transport.matrix(E2, d2) * transport.matrix(E1, d1);
    EXPECT_LT((both - apart).cwiseAbs().maxCoeff(), 1e-10 * both.norm()) << order;
  }
}

TEST(FieldTransport, jacobians_are_the_numerical_ones) {
  Dice dice;
  constexpr double kStep = 1e-5;
  for (int order = 1; order <= FieldBasis::kHighestOrder; ++order) {
    const FieldTransport transport(order);
    const VectorXd theta = dice.numbers(transport.basis().size());
    const Rot3 E = Rot3::Exp(dice.vector());
    const Vector3 d = dice.vector(0.5);
    const auto moved = transport.move(theta, E, d);
    const double scale = std::max(1.0, moved.by_theta.cwiseAbs().maxCoeff());
    for (int i = 0; i < 3; ++i) {
      const Vector3 h = kStep * Vector3::Unit(i);
      const VectorXd by_d =
          (transport.matrix(E, d + h) - transport.matrix(E, d - h)) * theta / (2 * kStep);
      const VectorXd by_turn = (transport.matrix(E * Rot3::Exp(h), d) -
                                transport.matrix(E * Rot3::Exp(Vector3(-h)), d)) *
                               theta / (2 * kStep);
      EXPECT_LT((moved.by_d.col(i) - by_d).cwiseAbs().maxCoeff(), 1e-6 * scale) << order;
      EXPECT_LT((moved.by_turn.col(i) - by_turn).cwiseAbs().maxCoeff(), 1e-6 * scale) << order;
    }
  }
}

}  // namespace
}  // namespace magimu
