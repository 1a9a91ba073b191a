// SPDX-License-Identifier: BSD-3-Clause
// Forward-mode automatic differentiation: a Dual<N> carries a value and its derivatives with
// respect to N inputs, d(f(x)) = f'(x) dx. It gives users' factors their Jacobians, and checks the
// analytic ones of ours. Comparisons look at the value only.
#pragma once

#include "graph/scalar.h"

namespace magimu {

template <int N>
struct Dual {
  double v = 0.0;
  Eigen::Array<double, N, 1> d = Eigen::Array<double, N, 1>::Zero();

  Dual() = default;
  Dual(double value) : v(value) {}  // NOLINT(google-explicit-constructor): constants mix freely
  Dual(double value, const Eigen::Array<double, N, 1>& derivatives) : v(value), d(derivatives) {}

  // The i-th of the N inputs.
  static Dual variable(double value, int i) {
    Dual x(value);
    x.d[i] = 1.0;
    return x;
  }

  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator-(const Dual& a) { return {-a.v, -a.d}; }
  friend Dual operator+(const Dual& a, const Dual& b) { return {a.v + b.v, a.d + b.d}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.v - b.v, a.d - b.d}; }
  friend Dual operator*(const Dual& a, const Dual& b) { return {a.v * b.v, a.d * b.v + b.d * a.v}; }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double q = a.v / b.v;
    return {q, (a.d - b.d * q) / b.v};
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
    return {s, a.d * (0.5 / s)};
  }
  friend Dual exp(const Dual& a) {
    const double e = std::exp(a.v);
    return {e, a.d * e};
  }
  friend Dual expm1(const Dual& a) { return {std::expm1(a.v), a.d * std::exp(a.v)}; }
  friend Dual log(const Dual& a) { return {std::log(a.v), a.d / a.v}; }
  friend Dual log1p(const Dual& a) { return {std::log1p(a.v), a.d / (1.0 + a.v)}; }
  friend Dual log10(const Dual& a) { return {std::log10(a.v), a.d / (a.v * std::log(10.0))}; }
  friend Dual pow(const Dual& a, double p) {
    return {std::pow(a.v, p), a.d * (p == 0.0 ? 0.0 : p * std::pow(a.v, p - 1.0))};
  }
  // A constant exponent serves any base; one that varies, only a positive base, or zero to a
  // positive power, which stays zero.
  friend Dual pow(const Dual& a, const Dual& b) {
    Dual y(std::pow(a.v, b.v));
    if ((a.d != 0.0).any()) y.d += pow(a, b.v).d;
    if ((b.d != 0.0).any() && !(a.v == 0.0 && b.v > 0.0)) y.d += b.d * (y.v * std::log(a.v));
    return y;
  }
  friend Dual sin(const Dual& a) { return {std::sin(a.v), a.d * std::cos(a.v)}; }
  friend Dual cos(const Dual& a) { return {std::cos(a.v), a.d * -std::sin(a.v)}; }
  friend Dual tan(const Dual& a) {
    const double t = std::tan(a.v);
    return {t, a.d * (1.0 + t * t)};
  }
  friend Dual asin(const Dual& a) { return {std::asin(a.v), a.d / std::sqrt(1.0 - a.v * a.v)}; }
  friend Dual acos(const Dual& a) { return {std::acos(a.v), a.d / -std::sqrt(1.0 - a.v * a.v)}; }
  friend Dual atan(const Dual& a) { return {std::atan(a.v), a.d / (1.0 + a.v * a.v)}; }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double n = x.v * x.v + y.v * y.v;
    return {std::atan2(y.v, x.v), (y.d * x.v - x.d * y.v) / n};
  }
  friend Dual sinh(const Dual& a) { return {std::sinh(a.v), a.d * std::cosh(a.v)}; }
  friend Dual cosh(const Dual& a) { return {std::cosh(a.v), a.d * std::sinh(a.v)}; }
  friend Dual tanh(const Dual& a) {
    const double c = std::cosh(a.v);
    return {std::tanh(a.v), a.d / (c * c)};
  }
  friend Dual hypot(const Dual& a, const Dual& b) {
    const double h = std::hypot(a.v, b.v);
    return {h, (a.d * a.v + b.d * b.v) / h};
  }
  friend Dual abs(const Dual& a) { return a.v < 0.0 ? -a : a; }
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
}  // namespace Eigen
