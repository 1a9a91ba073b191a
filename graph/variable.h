// SPDX-License-Identifier: BSD-3-Clause
// What can be an unknown: a Rot3, a double, or a fixed-size vector or matrix of double. The traits
// say how a value lies in flat memory (stored), how many degrees of freedom it has (tangent), and
// how an increment is applied: from the left for a rotation, by addition for all others (Huang et
// al. 2025, eq. (retraction)). Matrices are stored, and perturbed, column by column.
#pragma once

#include <cstdint>
#include <string>

#include "graph/dual.h"
#include "graph/rot3.h"

namespace magimu {

// The run-time identity of a variable's type. Rotations have kind 'R', everything else 'V'.
struct VariableType {
  char kind = 'V';
  std::uint16_t rows = 1, cols = 1;
  bool operator==(const VariableType&) const = default;
  int stored() const { return kind == 'R' ? 4 : rows * cols; }
  int tangent() const { return kind == 'R' ? 3 : rows * cols; }
};

std::string to_string(VariableType type);

// Writes retract(x, delta) to out; both have type.stored() doubles, delta type.tangent().
void retract(VariableType type, const double* x, const double* delta, double* out);
// The delta for which retract(x, delta) = y.
void local_coordinates(VariableType type, const double* x, const double* y, double* delta);

template <class V>
struct VariableTraits;

template <>
struct VariableTraits<Rot3> {
  static constexpr int kStored = 4, kTangent = 3;
  static constexpr VariableType type() { return {'R', 3, 3}; }
  template <class T>
  using Rebind = Rot3T<T>;
  template <class T>
  static Rot3T<T> load(const double* x) {
    return Rot3T<T>::from_unit_quaternion(Eigen::Map<const Vector4>(x).template cast<T>());
  }
  static void store(const Rot3& R, double* x) {
    Eigen::Map<Vector4> q(x);
    q = R.quaternion();
  }
  // The value at x, perturbed by the inputs first .. first + 2 of a Dual (all zero), as far as it
  // has them: 0 .. N - 1.
  template <int N>
  static Rot3T<Dual<N>> load_active(const double* x, int first) {
    Vec3<Dual<N>> delta;
    for (int i = 0; i < 3; ++i) delta[i] = Dual<N>::variable(0.0, first + i);
    return Rot3T<Dual<N>>::Exp(delta) * load<Dual<N>>(x);
  }
};

template <>
struct VariableTraits<double> {
  static constexpr int kStored = 1, kTangent = 1;
  static constexpr VariableType type() { return {'V', 1, 1}; }
  template <class T>
  using Rebind = T;
  template <class T>
  static T load(const double* x) {
    return T(*x);
  }
  static void store(double value, double* x) { *x = value; }
  template <int N>
  static Dual<N> load_active(const double* x, int first) {
    return Dual<N>::variable(*x, first);
  }
};

template <int R, int C>
requires(R > 0 && C > 0) struct VariableTraits<Mat<double, R, C>> {
  static constexpr int kStored = R * C, kTangent = R * C;
  static constexpr VariableType type() { return {'V', R, C}; }
  template <class T>
  using Rebind = Mat<T, R, C>;
  template <class T>
  static Mat<T, R, C> load(const double* x) {
    return Eigen::Map<const Mat<double, R, C>>(x).template cast<T>();
  }
  static void store(const Mat<double, R, C>& m, double* x) {
    Eigen::Map<Mat<double, R, C>> target(x);
    target = m;
  }
  template <int N>
  static Mat<Dual<N>, R, C> load_active(const double* x, int first) {
    Mat<Dual<N>, R, C> m;
    for (int i = 0; i < R * C; ++i) m(i % R, i / R) = Dual<N>::variable(x[i], first + i);
    return m;
  }
};

template <class V, class T>
using Rebind = typename VariableTraits<V>::template Rebind<T>;

template <class V>
concept Variable = requires {
  VariableTraits<V>::kTangent;
};

// Says at compile time that V is no variable; true if it is one.
template <class V>
consteval bool check_variable() {
  static_assert(
      Variable<V>,
      "magimu: a variable is a double, a Rot3, or a vector or matrix of double whose size "
      "is fixed (Vec<double, n>, Mat<double, m, n>): cast numbers of other types, make a "
      "quaternion a Rot3 (Rot3::from_quaternion), a struct of your own a vector");
  return Variable<V>;
}

}  // namespace magimu
