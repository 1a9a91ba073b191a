// SPDX-License-Identifier: BSD-3-Clause
#include "graph/dual.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace magimu {
namespace {

using D1 = Dual<1>;
using D2 = Dual<2>;

// f is a generic function of one or two scalars; value and derivatives against central differences.
template <class F>
void expect_derivative(const char* name, const F& f, std::initializer_list<double> points) {
  constexpr double kStep = 1e-5;
  for (const double x : points) {
    const D1 y = f(D1::variable(x, 0));
    const double slope = (f(x + kStep) - f(x - kStep)) / (2.0 * kStep);
    EXPECT_DOUBLE_EQ(y.v, f(x)) << name << " at " << x;
    EXPECT_NEAR(y.d[0], slope, 1e-8 * (1.0 + std::abs(slope))) << name << " at " << x;
  }
}
template <class F>
void expect_derivatives(const char* name, const F& f, std::initializer_list<double> points) {
  constexpr double kStep = 1e-5;
  for (const double a : points) {
    for (const double b : points) {
      const D2 y = f(D2::variable(a, 0), D2::variable(b, 1));
      const double da = (f(a + kStep, b) - f(a - kStep, b)) / (2.0 * kStep);
      const double db = (f(a, b + kStep) - f(a, b - kStep)) / (2.0 * kStep);
      EXPECT_DOUBLE_EQ(y.v, f(a, b)) << name << " at " << a << ", " << b;
      EXPECT_NEAR(y.d[0], da, 1e-8 * (1.0 + std::abs(da))) << name << " at " << a << ", " << b;
      EXPECT_NEAR(y.d[1], db, 1e-8 * (1.0 + std::abs(db))) << name << " at " << a << ", " << b;
    }
  }
}

TEST(Dual, functions_of_one_variable_have_their_derivatives) {
  using std::abs, std::acos, std::asin, std::atan, std::cos, std::cosh, std::exp, std::expm1;
  using std::log, std::log10, std::log1p, std::pow, std::sin, std::sinh, std::sqrt, std::tan;
  using std::tanh;
  expect_derivative("sqrt", [](auto x) { return sqrt(x); }, {0.1, 1.0, 7.0});
  expect_derivative("exp", [](auto x) { return exp(x); }, {-2.0, 0.0, 1.5});
  expect_derivative("log", [](auto x) { return log(x); }, {0.1, 1.0, 7.0});
  expect_derivative("expm1", [](auto x) { return expm1(x); }, {-2.0, 0.0, 1.5});
  expect_derivative("log1p", [](auto x) { return log1p(x); }, {-0.5, 0.0, 7.0});
  expect_derivative("log10", [](auto x) { return log10(x); }, {0.1, 1.0, 7.0});
  expect_derivative("pow 2.5", [](auto x) { return pow(x, 2.5); }, {0.1, 1.0, 7.0});
  expect_derivative("pow 3", [](auto x) { return pow(x, 3.0); }, {-2.0, 0.0, 1.5});
  expect_derivative("pow 0", [](auto x) { return pow(x, 0.0); }, {-2.0, 0.0, 1.5});
  expect_derivative("sin", [](auto x) { return sin(x); }, {-2.0, 0.0, 1.5});
  expect_derivative("cos", [](auto x) { return cos(x); }, {-2.0, 0.0, 1.5});
  expect_derivative("tan", [](auto x) { return tan(x); }, {-2.0, 0.0, 1.2});
  expect_derivative("asin", [](auto x) { return asin(x); }, {-0.9, 0.0, 0.5});
  expect_derivative("acos", [](auto x) { return acos(x); }, {-0.9, 0.0, 0.5});
  expect_derivative("sinh", [](auto x) { return sinh(x); }, {-2.0, 0.0, 1.5});
  expect_derivative("cosh", [](auto x) { return cosh(x); }, {-2.0, 0.0, 1.5});
  expect_derivative("tanh", [](auto x) { return tanh(x); }, {-2.0, 0.0, 1.5});
  expect_derivative("2 to the power", [](auto x) { return pow(decltype(x)(2.0), x); },
                    {-2.0, 0.0, 1.5});
  expect_derivative("atan", [](auto x) { return atan(x); }, {-2.0, 0.0, 1.5});
  expect_derivative("abs", [](auto x) { return abs(x); }, {-2.0, 1.5});
  expect_derivative("minus", [](auto x) { return -x; }, {-2.0, 0.0, 1.5});
}

TEST(Dual, functions_of_two_variables_have_their_derivatives) {
  using std::atan2, std::hypot, std::pow;
  expect_derivatives("+", [](auto a, auto b) { return a + b; }, {-2.0, 0.5, 3.0});
  expect_derivatives("-", [](auto a, auto b) { return a - b; }, {-2.0, 0.5, 3.0});
  expect_derivatives("*", [](auto a, auto b) { return a * b; }, {-2.0, 0.5, 3.0});
  expect_derivatives("/", [](auto a, auto b) { return a / b; }, {-2.0, 0.5, 3.0});
  expect_derivatives("pow", [](auto a, auto b) { return pow(a, b); }, {0.2, 1.0, 3.0});
  expect_derivatives("hypot", [](auto a, auto b) { return hypot(a, b); }, {-2.0, 0.5, 3.0});
  expect_derivatives("atan2", [](auto y, auto x) { return atan2(y, x); }, {-2.0, -0.1, 0.5, 3.0});
}

TEST(Dual, assigning_operators_agree_with_the_plain_ones) {
  expect_derivatives("+= -= *= /=",
                     [](auto a, auto b) {
                       auto x = a;
                       x += b * 2.0;
                       x *= a;
                       x -= 3.0;
                       x /= b;
                       x *= x;
                       return x;
                     },
                     {-2.0, 0.5, 3.0});
}

TEST(Dual, constants_mix_in_on_either_side) {
  expect_derivative("mixed", [](auto x) { return 2.0 * x + 1.0 - 3.0 / (1.0 + x) * (5.0 - x); },
                    {-2.0, 0.0, 1.5});
}

// A template that serves double and Dual may write a constant exponent as T(2), of any base.
TEST(Dual, a_constant_exponent_works_for_any_base) {
  using std::pow;
  for (const double x : {-1.5, 0.0, 2.0}) {
    const D1 y = pow(D1::variable(x, 0), D1(2.0));
    EXPECT_DOUBLE_EQ(y.v, x * x);
    EXPECT_DOUBLE_EQ(y.d[0], 2.0 * x);
  }
}

// A model such as b x^c is asked at x = 0, too.
TEST(Dual, zero_to_a_power_that_varies_stays_zero) {
  using std::pow;
  for (const double exponent : {0.5, 1.5}) {
    const D1 y = pow(D1(0.0), D1::variable(exponent, 0));
    EXPECT_EQ(y.v, 0.0);
    EXPECT_EQ(y.d[0], 0.0);
  }
}

// Far out, where tanh is 1 to the last digit, its slope is zero and no number is infinite.
TEST(Dual, tanh_saturates) {
  for (const double x : {-800.0, 800.0}) {
    EXPECT_EQ(tanh(D1::variable(x, 0)).v, x < 0.0 ? -1.0 : 1.0);
    EXPECT_EQ(tanh(D1::variable(x, 0)).d[0], 0.0);
  }
}

TEST(Dual, select_takes_value_and_derivatives_of_the_side_chosen) {
  const D2 a = D2::variable(1.0, 0), b = D2::variable(2.0, 1);
  EXPECT_EQ(select(true, a, b).v, 1.0);
  EXPECT_EQ(select(true, a, b).d[0], 1.0);
  EXPECT_EQ(select(true, a, b).d[1], 0.0);
  EXPECT_EQ(select(false, a, b).v, 2.0);
  EXPECT_EQ(select(false, a, b).d[0], 0.0);
  EXPECT_EQ(select(false, a, b).d[1], 1.0);
  EXPECT_EQ(select(a < b, 1.0, 2.0), 1.0);
}

TEST(Dual, comparisons_look_at_the_value_only) {
  const D1 a = D1::variable(1.0, 0), b(1.0), c(2.0);
  EXPECT_TRUE(a == b && a <= b && a >= b && a < c && c > a && a != c);
  EXPECT_FALSE(a != b || a < b || a > b || a == c || c <= a || a >= c);
}

TEST(Dual, eigen_computes_with_it) {
  // f(x) = x' A x / |x|^2, whose gradient is 2 (A x - f x) / |x|^2 for a symmetric A
  Eigen::Matrix3d A;
  A << 2.0, 0.3, -0.4, 0.3, 1.0, 0.7, -0.4, 0.7, 3.0;
  const Eigen::Vector3d at(0.3, -1.0, 0.8);
  Vec<Dual<3>, 3> x;
  for (int i = 0; i < 3; ++i) x[i] = Dual<3>::variable(at[i], i);
  const Dual<3> f = x.dot(A.cast<Dual<3>>() * x) / x.squaredNorm();
  const double value = at.dot(A * at) / at.squaredNorm();
  const Eigen::Vector3d gradient = 2.0 * (A * at - value * at) / at.squaredNorm();
  EXPECT_DOUBLE_EQ(f.v, value);
  EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(f.d.data()) - gradient).norm(), 1e-14);
}

TEST(Dual, constants_of_double_need_no_cast) {
  Eigen::Matrix2d A;
  A << 1.0, 2.0, 3.0, 4.0;
  const Vec<Dual<2>, 2> x(Dual<2>::variable(0.5, 0), Dual<2>::variable(-1.0, 1));
  const Vec<Dual<2>, 2> y = A * x + 2 * x - Eigen::Vector2d(1.0, 1.0);
  const Vec<Dual<2>, 2> same = A.cast<Dual<2>>() * x + Dual<2>(2.0) * x - Vec<Dual<2>, 2>(1.0, 1.0);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(y[i].v, same[i].v);
    EXPECT_EQ(y[i].d, same[i].d);
  }
}

}  // namespace
}  // namespace magimu
