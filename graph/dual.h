// SPDX-License-Identifier: BSD-3-Clause
// Forward-mode automatic differentiation: a Dual<N> carries a value and its derivatives with
// respect to N inputs, d(f(x)) = f'(x) dx. It gives users' factors their Jacobians, and checks the
// analytic ones of ours. Comparisons look at the value only.
#pragma once

#include <algorithm>
#include <array>

#include "graph/scalar.h"

namespace magimu {

template <int N>
struct Dual {
  double v = 0.0;
  std::array<double, std::size_t(N)> d{};

  Dual() = default;
  Dual(double value) : v(value) {}  // NOLINT(google-explicit-constructor): constants mix freely
  // The chain rule: d = outer times that of the inner value.
  Dual(double value, double outer, const Dual& inner) : v(value) {
    for (std::size_t i = 0; i < d.size(); ++i) d[i] = inner.d[i] * outer;
  }
  // d = a.d f + b.d g.
  Dual(double value, const Dual& a, double f, const Dual& b, double g) : v(value) {
    for (std::size_t i = 0; i < d.size(); ++i) d[i] = a.d[i] * f + b.d[i] * g;
  }

  // The i-th of the N inputs; a constant where there is no such.
  static Dual variable(double value, int i) {
    Dual x(value);
    if (0 <= i && i < N) x.d[std::size_t(i)] = 1.0;
    return x;
  }

  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator-(const Dual& a) { return {-a.v, -1.0, a}; }
  friend Dual operator+(const Dual& a, const Dual& b) { return {a.v + b.v, a, 1.0, b, 1.0}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.v - b.v, a, 1.0, b, -1.0}; }
  friend Dual operator*(const Dual& a, const Dual& b) { return {a.v * b.v, a, b.v, b, a.v}; }
  friend Dual operator/(const Dual& a, const Dual& b) {
    Dual q(a.v / b.v, a, 1.0, b, -a.v / b.v);
    for (double& derivative : q.d) derivative /= b.v;
    return q;
  }
  friend bool operator<(const Dual& a, const Dual& b) { return a.v < b.v; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.v > b.v; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.v <= b.v; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.v >= b.v; }
  friend bool operator==(const Dual& a, const Dual& b) { return a.v == b.v; }
  friend bool operator!=(const Dual& a, const Dual& b) { return a.v != b.v; }

  friend Dual select(bool condition, const Dual& a, const Dual& b) { return condition ? a : b; }
  friend double value_of(const Dual& a) { return a.v; }

  friend Dual sqrt(const Dual& a) {
    const double s = std::sqrt(a.v);
    return {s, 0.5 / s, a};
  }
  friend Dual exp(const Dual& a) {
    const double e = std::exp(a.v);
    return {e, e, a};
  }
  friend Dual expm1(const Dual& a) { return {std::expm1(a.v), std::exp(a.v), a}; }
  friend Dual log(const Dual& a) { return {std::log(a.v), 1.0 / a.v, a}; }
  friend Dual log1p(const Dual& a) { return {std::log1p(a.v), 1.0 / (1.0 + a.v), a}; }
  friend Dual log10(const Dual& a) { return {std::log10(a.v), 1.0 / (a.v * std::log(10.0)), a}; }
  friend Dual pow(const Dual& a, double p) {
    return {std::pow(a.v, p), p == 0.0 ? 0.0 : p * std::pow(a.v, p - 1.0), a};
  }
  // A constant exponent serves any base; one that varies, only a positive base, or zero to a
  // positive power, which stays zero.
  friend Dual pow(const Dual& a, const Dual& b) {
    Dual y(std::pow(a.v, b.v));
    if (a.varies()) y = pow(a, b.v);
    if (b.varies() && !(a.v == 0.0 && b.v > 0.0)) y = {y.v, y, 1.0, b, y.v * std::log(a.v)};
    return y;
  }
  friend Dual sin(const Dual& a) { return {std::sin(a.v), std::cos(a.v), a}; }
  friend Dual cos(const Dual& a) { return {std::cos(a.v), -std::sin(a.v), a}; }
  friend Dual tan(const Dual& a) {
    const double t = std::tan(a.v);
    return {t, 1.0 + t * t, a};
  }
  friend Dual asin(const Dual& a) { return {std::asin(a.v), 1.0 / std::sqrt(1.0 - a.v * a.v), a}; }
  friend Dual acos(const Dual& a) { return {std::acos(a.v), -1.0 / std::sqrt(1.0 - a.v * a.v), a}; }
  friend Dual atan(const Dual& a) { return {std::atan(a.v), 1.0 / (1.0 + a.v * a.v), a}; }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double n = x.v * x.v + y.v * y.v;
    return {std::atan2(y.v, x.v), y, x.v / n, x, -y.v / n};
  }
  friend Dual sinh(const Dual& a) { return {std::sinh(a.v), std::cosh(a.v), a}; }
  friend Dual cosh(const Dual& a) { return {std::cosh(a.v), std::sinh(a.v), a}; }
  friend Dual tanh(const Dual& a) {
    const double c = std::cosh(a.v);
    return {std::tanh(a.v), 1.0 / (c * c), a};
  }
  friend Dual hypot(const Dual& a, const Dual& b) {
    const double h = std::hypot(a.v, b.v);
    return {h, a, a.v / h, b, b.v / h};
  }
  friend Dual abs(const Dual& a) { return a.v < 0.0 ? -a : a; }

 private:
  bool varies() const {
    return std::any_of(d.begin(), d.end(), [](double x) { return x != 0.0; });
  }
};

}  // namespace magimu

namespace Eigen {
template <int N>
struct NumTraits<magimu::Dual<N>> : NumTraits<double> {
  using Real = magimu::Dual<N>;
  using NonInteger = magimu::Dual<N>;
  using Nested = magimu::Dual<N>;
  using Literal = double;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1 };
  enum { ReadCost = N + 1, AddCost = N + 1, MulCost = 3 * N + 1 };
};
// A matrix of double times a vector of Dual: constants of a factor need no cast.
template <int N, class Operation>
struct ScalarBinaryOpTraits<magimu::Dual<N>, double, Operation> {
  using ReturnType = magimu::Dual<N>;
};
template <int N, class Operation>
struct ScalarBinaryOpTraits<double, magimu::Dual<N>, Operation> {
  using ReturnType = magimu::Dual<N>;
};
}  // namespace Eigen
