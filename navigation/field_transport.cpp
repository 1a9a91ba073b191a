// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/field_transport.h"

#include <Eigen/QR>
#include <cmath>
#include <numbers>

#include "graph/so3.h"

namespace magimu {
namespace {

// Points on a spiral over spheres of two sizes: no polynomial of a low order vanishes on them.
std::vector<Vector3> spiral_points(int count) {
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    const double radius = i % 2 == 0 ? 1.0 : 0.6;
    points.push_back(radius * Vector3(r * std::cos(turn * i), r * std::sin(turn * i), z));
  }
  return points;
}

}  // namespace

FieldTransport::FieldTransport(int order) : basis_(order) {
  // Half as many equations again as coefficients.
  points_ = spiral_points(basis_.size() / 2 + 1);
  solve_ = basis_.at(points_).completeOrthogonalDecomposition().pseudoInverse();
}

MatrixXd FieldTransport::matrix(const Rot3& E, const Vector3& d) const {
  const Matrix3 turn = E.matrix();
  MatrixXd b(3 * points_.size(), basis_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    b.middleRows<3>(static_cast<Eigen::Index>(3 * i)).noalias() =
        turn.transpose() * basis_.at(Vector3(turn * points_[i] + d));
  }
  return solve_ * b;
}

FieldTransport::Moved FieldTransport::move(const VectorXd& theta, const Rot3& E,
                                           const Vector3& d) const {
  const Matrix3 turn = E.matrix();
  Moved moved;
  moved.by_theta = matrix(E, d);
  moved.theta = moved.by_theta * theta;
  MatrixXd by_d(3 * points_.size(), 3), by_turn(3 * points_.size(), 3);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vector3& c = points_[i];
    const auto row = static_cast<Eigen::Index>(3 * i);
    const Vector3 f = basis_.at(c) * moved.theta;  // in the new frame
    const Matrix3 slope = turn.transpose() * basis_.gradient(theta, turn * c + d);
    by_d.middleRows<3>(row) = slope;
    by_turn.middleRows<3>(row) = so3::hat<double>(f) - slope * turn * so3::hat<double>(c);
  }
  moved.by_d = solve_ * by_d;
  moved.by_turn = solve_ * by_turn;
  return moved;
}

}  // namespace magimu
