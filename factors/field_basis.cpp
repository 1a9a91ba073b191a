// SPDX-License-Identifier: BSD-3-Clause
#include "factors/field_basis.h"

#include <cassert>
#include <map>

namespace magimu {
namespace {

using Power = std::array<int, 3>;
using Polynomial = std::map<Power, double>;

Polynomial derivative(const Polynomial& p, int axis) {
  Polynomial out;
  for (const auto& [power, factor] : p) {
    if (power[axis] == 0) continue;
    Power lower = power;
    --lower[axis];
    out[lower] += factor * power[axis];
  }
  return out;
}

Polynomial plane_laplacian(const Polynomial& p) {
  Polynomial out;
  for (const int axis : {0, 1}) {
    for (const auto& [power, factor] : derivative(derivative(p, axis), axis)) out[power] += factor;
  }
  return out;
}

// The potential that is x^a y^b z^c on the plane z = 0 (c = 0: itself; c = 1: its derivative by z).
Polynomial harmonic(int a, int b, int c) {
  Polynomial out;
  double factor = 1.0;  // (-1)^k c! / (2k+c)!
  int degree = c;
  for (Polynomial plane{{Power{a, b, 0}, 1.0}}; !plane.empty(); plane = plane_laplacian(plane)) {
    for (const auto& [power, value] : plane) out[{power[0], power[1], degree}] += factor * value;
    factor /= -1.0 * (degree + 1) * (degree + 2);
    degree += 2;
  }
  return out;
}

using PowerTable = std::array<std::array<double, FieldBasis::kHighestOrder + 1>, 3>;

PowerTable powers_of(const Vector3& r, int order) {
  PowerTable table;
  for (int axis = 0; axis < 3; ++axis) {
    table[axis][0] = 1.0;
    for (int n = 1; n <= order; ++n) table[axis][n] = table[axis][n - 1] * r[axis];
  }
  return table;
}

}  // namespace

FieldBasis::FieldBasis(int order) : order_(order) {
  assert(order >= 1 && order <= kHighestOrder);
  int column = 0;
  for (int n = 1; n <= order + 1; ++n) {
    for (int a = 0; a <= n; ++a) {
      for (int b = 0; a + b <= n; ++b) {
        const int c = n - a - b;
        if (c > 1) continue;
        const Polynomial potential = harmonic(a, b, c);
        for (int axis = 0; axis < 3; ++axis) {
          for (const auto& [power, factor] : derivative(potential, axis)) {
            terms_.push_back({column, axis, power, factor});
          }
        }
        ++column;
      }
    }
  }
  assert(column == size());
}

int FieldBasis::degree_of(int column) {
  // Degrees 0 to n have (n + 1)(n + 3) columns together.
  int degree = 0;
  while ((degree + 1) * (degree + 3) <= column) ++degree;
  return degree;
}

Matrix3X FieldBasis::at(const Vector3& r) const {
  const PowerTable table = powers_of(r, order_);
  Matrix3X phi = Matrix3X::Zero(3, size());
  for (const Term& t : terms_) {
    phi(t.axis, t.column) +=
        t.factor * table[0][t.power[0]] * table[1][t.power[1]] * table[2][t.power[2]];
  }
  return phi;
}

MatrixXd FieldBasis::at(const std::vector<Vector3>& points) const {
  MatrixXd stacked(3 * points.size(), size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    stacked.middleRows<3>(static_cast<Eigen::Index>(3 * i)) = at(points[i]);
  }
  return stacked;
}

Matrix3 FieldBasis::gradient(const VectorXd& theta, const Vector3& r) const {
  const PowerTable table = powers_of(r, order_);
  Matrix3 gradient = Matrix3::Zero();
  for (const Term& t : terms_) {
    const double value = t.factor * theta[t.column];
    for (int by = 0; by < 3; ++by) {
      if (t.power[by] == 0) continue;
      double slope = value * t.power[by];
      for (int axis = 0; axis < 3; ++axis) {
        slope *= table[axis][t.power[axis] - (axis == by ? 1 : 0)];
      }
      gradient(t.axis, by) += slope;
    }
  }
  return gradient;
}

}  // namespace magimu
