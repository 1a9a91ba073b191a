// SPDX-License-Identifier: BSD-3-Clause
// A field that differs from place to place. Where no current flows and no iron is, it has neither
// curl nor divergence, so that about the middle of the sensor's path it is a sum of gradients of
// harmonic polynomials (factors/field_basis.h), the constant being the Earth's field:
//
//   b(p) = sum over degrees 1 .. order of Phi_d((p - middle) / reach) S_d theta_d    uT, in n
//
// with theta ~ N(0, 1) and S_d such that along the path each degree is expected to be as large as a
// departure of a given size. p is the position that the model of a hand-held sensor estimates; by
// the gradient of b the magnetometer tells of it, too. Each recording has a field of its own:
// nothing tells where one begins beside another.
//
// It is linear about a point, theta and shift of each node:
//   b = columns theta + gradient (shift - shift there).
#pragma once

#include <vector>

#include "factors/field_basis.h"
#include "factors/harmonic_field.h"

namespace magimu {

class FieldOfPlace {
 public:
  static constexpr int kHighestOrder = 3;

  // position, recording: of each node. size_uT: of each component, along the path.
  FieldOfPlace(std::vector<Vector3> position, std::vector<int> recording, int order,
               double size_uT);

  int order() const { return order_; }
  int coefficients() const { return int(theta_.size()); }
  // Root mean square distance from the middle of the path, m, the least of all recordings.
  double reach_m() const { return reach_m_; }

  // About another point. shift: of each node's position, m.
  void linearize_at(const VectorXd& theta, std::vector<Vector3> shift);
  const VectorXd& theta() const { return theta_; }
  const Vector3& shift(std::size_t node) const { return shift_[node]; }

  MatrixXd columns(std::size_t node) const;  // 3 x coefficients, uT
  Matrix3 gradient(std::size_t node) const;  // d b / d p, uT/m
  Vector3 field_uT(std::size_t node) const;  // b
  Vector3 position(std::size_t node) const;  // m, where it is linear about

  // The same of each recording as an effect has it, and theta in its unit, uT.
  std::vector<HarmonicField> harmonic_fields() const;
  VectorXd coefficients_uT() const;

 private:
  struct Path {
    Vector3 middle = Vector3::Zero();
    double reach_m = 0.0;
    VectorXd scale;  // of each column but the constant ones
  };
  Vector3 seen_from_middle(std::size_t node) const;
  int of_one() const { return FieldBasis::size_of(order_) - 3; }

  std::vector<Vector3> position_, shift_;
  std::vector<int> recording_;
  int order_;
  FieldBasis basis_;
  std::vector<Path> paths_;
  VectorXd theta_;
  double reach_m_ = 0.0;
};

}  // namespace magimu
