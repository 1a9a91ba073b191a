// SPDX-License-Identifier: BSD-3-Clause
// Polynomial models of a magnetic field that are free of curl and divergence: gradients of harmonic
// polynomials of the degrees 1 to order + 1, of which there are 2 n + 1 of degree n. In free space
// every field is of this form near a point (Maxwell's equations without currents), so a few
// coefficients describe what all magnetometers of an array read.
//
//   F(r) = Phi(r) theta,  Phi 3 x kappa,  kappa = order^2 + 4 order + 3 = 8, 15, 24, 35
//
// The basis: for a + b + c = n with c in {0, 1} the potential
//
//   H = sum_k (-1)^k c! z^(2k+c) / (2k+c)! Lap_xy^k (x^a y^b),
//
// ordered by rising n, then a, then b; a column of Phi is its gradient. The first coefficients are
// the field at the origin (z, y, x). Units of theta: field, field/m, field/m^2, ...
#pragma once

#include <array>
#include <vector>

#include "graph/scalar.h"

namespace magimu {

using Matrix3X = Eigen::Matrix<double, 3, Eigen::Dynamic>;

class FieldBasis {
 public:
  static constexpr int kHighestOrder = 4;

  // order: 1 to kHighestOrder, the polynomials' degree.
  explicit FieldBasis(int order);

  int order() const { return order_; }
  int size() const { return size_of(order_); }  // kappa
  static int size_of(int order) { return order * order + 4 * order + 3; }
  // Degree of the polynomials of column i: 0 for the first three, 1 for the next five, ...
  static int degree_of(int column);

  // Phi(r); r in m.
  Matrix3X at(const Vector3& r) const;
  // One Phi below the other.
  MatrixXd at(const std::vector<Vector3>& points) const;
  // The field's derivative by r, 3 x 3 (symmetric, without trace).
  Matrix3 gradient(const VectorXd& theta, const Vector3& r) const;

 private:
  struct Term {
    int column, axis;
    std::array<int, 3> power;  // of x, y, z
    double factor;
  };
  int order_;
  std::vector<Term> terms_;
};

}  // namespace magimu
