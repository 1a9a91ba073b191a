// SPDX-License-Identifier: BSD-3-Clause
// A factor is one thing we know: a residual that should be near zero, the variables it depends on,
// and how near (its noise). The graph's cost is half the sum of the squared whitened residuals.
//
// To write one, derive from Factor<rows of the residual, types of the variables...> and give the
// residual once, as a template over the scalar:
//
//   class RangeFactor : public Factor<1, Vector2> {
//    public:
//     RangeFactor(Key position, double range, const Noise<1>& noise)
//         : Factor({position}, noise), range_(range) {}
//     template <class T>
//     Vec<T, 1> residual(const Vec<T, 2>& p) const {
//       using std::sqrt;  // a number's or a differentiable one's
//       return Vec<T, 1>(sqrt(p.dot(p)) - range_);
//     }
//    private:
//     double range_;
//   };
//
// Its Jacobians then come from automatic differentiation (dual.h). A factor that knows them adds
//
//     template <class T>
//     Vec<T, 1> linearize(const Vec<T, 2>& p, Mat<T, 1, 2>& J_p) const;
//
// which returns the residual and fills one Jacobian a variable, d residual / d tangent, not
// whitened (the rotation's tangent: R <- Exp(delta) R). Tests check it with numerical_derivative.h.
// A factor is copied into the graph and never sees a solver.
#pragma once

#include <algorithm>
#include <array>
#include <tuple>
#include <type_traits>
#include <utility>

#include "graph/key.h"
#include "graph/lanes.h"
#include "graph/noise.h"
#include "graph/variable.h"

namespace magimu {

namespace detail {

template <int given, int variables>
constexpr void check_number_of_keys() {
  static_assert(given == variables,
                "magimu: a factor is made with one key a variable of Factor<rows, variables...>, "
                "in their order: the numbers differ (check_number_of_keys<given, variables>)");
}

}  // namespace detail

template <int Dim, class... V>
class Factor {
 public:
  using AreVariables = std::bool_constant<(check_variable<V>() && ...)>;
  static constexpr int kDim = Dim;
  static constexpr int kKeys = int(sizeof...(V));
  static constexpr int kColumns = (VariableTraits<V>::kTangent + ...);
  using Variables = std::tuple<V...>;
  using Keys = std::array<Key, sizeof...(V)>;

  Factor(const Keys& keys, const Noise<Dim>& noise) : keys_(keys), noise_(noise) {}
  // Factor({first, second}, noise): std::array alone would fill missing keys up with "?0".
  template <std::size_t N>
  Factor(const Key (&keys)[N], const Noise<Dim>& noise) : noise_(noise) {
    detail::check_number_of_keys<int(N), kKeys>();
    std::copy_n(keys, std::min(N, sizeof...(V)), keys_.begin());
  }

  const Keys& keys() const { return keys_; }
  const Noise<Dim>& noise() const { return noise_; }

 private:
  Keys keys_;
  Noise<Dim> noise_;
};

namespace detail {

template <class F>
inline constexpr auto kIndices = std::make_index_sequence<std::size_t(F::kKeys)>();

template <class F, std::size_t I>
using VariableOf = std::tuple_element_t<I, typename F::Variables>;

// First tangent column of the I-th variable of F.
template <class F, std::size_t I>
constexpr int first_column() {
  return []<std::size_t... J>(std::index_sequence<J...>) {
    return (0 + ... + VariableTraits<VariableOf<F, J>>::kTangent);
  }
  (std::make_index_sequence<I>());
}

template <class F, std::size_t... I>
auto residual_at(const F& f, const std::array<const double*, sizeof...(I)>& x,
                 std::index_sequence<I...>) {
  return f.template residual<double>(
      VariableTraits<VariableOf<F, I>>::template load<double>(x[I])...);
}

// Columns of a Jacobian that automatic differentiation finds at a time: one kind of Dual for all
// factors is compiled once.
inline constexpr int kAtATime = 4;

// The residual and its derivatives with respect to the columns from begin on.
template <class F, std::size_t... I>
auto residual_dual(const F& f, const std::array<const double*, sizeof...(I)>& x, int begin,
                   std::index_sequence<I...>) {
  return f.template residual<Dual<kAtATime>>(
      VariableTraits<VariableOf<F, I>>::template load_active<kAtATime>(
          x[I], first_column<F, I>() - begin)...);
}

template <class F, class Variables = typename F::Variables>
struct Jacobians;
template <class F, class... V>
struct Jacobians<F, std::tuple<V...>> {
  using type = std::tuple<Mat<double, F::kDim, VariableTraits<V>::kTangent>...>;
};
template <class F>
using JacobianTuple = typename Jacobians<F>::type;

template <class F, std::size_t... I>
auto linearize_at(const F& f, const std::array<const double*, sizeof...(I)>& x, JacobianTuple<F>& J,
                  std::index_sequence<I...>)
    -> decltype(f.template linearize<double>(
        VariableTraits<VariableOf<F, I>>::template load<double>(x[I])..., std::get<I>(J)...)) {
  return f.template linearize<double>(
      VariableTraits<VariableOf<F, I>>::template load<double>(x[I])..., std::get<I>(J)...);
}

template <class F>
concept HasAnalyticJacobians = requires(const F& f, std::array<const double*, F::kKeys> x,
                                        JacobianTuple<F>& J) {
  linearize_at(f, x, J, kIndices<F>);
};

// Has F a member of the name linearize, whatever its signature? Then the name is ambiguous here.
struct NamesLinearizeToo {
  void linearize();
};
template <class F>
struct BothNames : F, NamesLinearizeToo {};
template <class F>
concept NamesLinearize = !std::is_final_v<F> && !requires {
  &BothNames<F>::linearize;
};

// Has F a member of the name residual, whatever its signature?
struct NamesResidualToo {
  void residual();
};
template <class F>
struct BothResiduals : F, NamesResidualToo {};
template <class F>
concept NamesResidual = std::is_final_v<F> || !requires {
  &BothResiduals<F>::residual;
};

template <int Dim, class... V>
std::true_type derives_from_factor(const Factor<Dim, V...>*);
std::false_type derives_from_factor(const void*);
template <class F>
concept DerivesFromFactor = decltype(derives_from_factor(static_cast<const F*>(nullptr)))::value;

template <class F, class T, std::size_t... I>
auto residual_over(F& f, std::index_sequence<I...>) -> decltype(f.template residual<T>(
    std::declval<const typename VariableTraits<VariableOf<F, I>>::template Rebind<T>&>()...));
// F's residual can be called, with T for the scalar, for one value of each variable.
template <class F, class T>
concept ResidualOver = requires(F& f) {
  residual_over<F, T>(f, kIndices<std::remove_const_t<F>>);
};

// Becomes a matrix of any other size than X. Eigen's matrices accept each other in a declaration,
// and complain from deep inside where they are used.
template <class X>
struct OfOtherSize {};
template <class T, int R, int C>
struct OfOtherSize<Mat<T, R, C>> {
  template <int M, int N>
  requires(M != R || N != C) operator const Mat<T, M, N>&() const;
};
template <class F, std::size_t I, std::size_t J>
auto argument() {
  using X = typename VariableTraits<VariableOf<F, J>>::template Rebind<double>;
  if constexpr (I == J) {
    return OfOtherSize<X>();
  } else {
    return X();
  }
}
template <class F, std::size_t I, std::size_t... J>
auto with_other_size(const F& f, std::index_sequence<J...>)
    -> decltype(f.template residual<double>(std::declval<decltype(argument<F, I, J>())>()...));
// F's residual takes another size of vector or matrix than its I-th variable has.
template <class F, std::size_t I>
concept TakesOtherSize = requires(const F& f) {
  with_other_size<F, I>(f, kIndices<F>);
};
template <class F, std::size_t... I>
consteval bool takes_other_size(std::index_sequence<I...>) {
  return (TakesOtherSize<F, I> || ...);
}

template <class F>
using ReturnOfResidual =
    decltype(residual_over<const F, double>(std::declval<const F&>(), kIndices<F>));

}  // namespace detail

// Says at compile time what a class lacks to be a factor, in the order in which one writes it; true
// if it lacks nothing.
template <class F>
consteval bool check_residual() {
  constexpr bool callable = detail::ResidualOver<const F, double>;
  constexpr bool changes = !callable && detail::ResidualOver<F, double>;
  static_assert(!changes,
                "magimu: a factor's residual() does not change the factor: declare it const");
  static_assert(
      callable || changes,
      "magimu: a factor's residual() must be public, a template over its scalar alone, and take "
      "one argument a variable, in the order of Factor<rows, variables...>: const Vec<T, n>& for "
      "a vector of n numbers, const Mat<T, m, n>&, const Rot3T<T>& for a rotation, const T& for "
      "a double");
  constexpr bool other_size = detail::takes_other_size<F>(detail::kIndices<F>);
  static_assert(
      !other_size,
      "magimu: an argument of a factor's residual() has another size than the variable of "
      "Factor<rows, variables...> in its place: Vec<T, n> for a Vec<double, n>");
  if constexpr (callable && !other_size) {
    using Return = detail::ReturnOfResidual<F>;
    constexpr bool differentiable =
        detail::HasAnalyticJacobians<F> || detail::ResidualOver<const F, Dual<detail::kAtATime>>;
    constexpr bool number = std::is_void_v<Return> || std::is_arithmetic_v<Return>;
    constexpr bool right = std::is_same_v<Return, Vec<double, F::kDim>>;
    static_assert(
        differentiable,
        "magimu: a factor's residual() must work for any scalar T, not for double alone: its "
        "Jacobians come from automatic differentiation, unless the factor has linearize()");
    static_assert(
        !number,
        "magimu: a factor's residual() returns a vector, of one row, too: Vec<T, 1>(value)");
    static_assert(
        right || number,
        "magimu: a factor's residual() returns Vec<T, rows>, with the rows of Factor<rows, "
        "...>, by value; not auto, which would be an expression of Eigen's that refers to "
        "numbers that are gone");
    return differentiable && right;
  }
  return false;
}
template <class F>
consteval bool check_factor() {
  constexpr bool derives = detail::DerivesFromFactor<F>;
  static_assert(
      derives,
      "magimu: a factor derives publicly from Factor<rows of its residual, the types of its "
      "variables...>");
  if constexpr (derives) {
    constexpr bool copied = std::is_copy_constructible_v<F>, named = detail::NamesResidual<F>;
    static_assert(
        copied, "magimu: the graph keeps a copy of each factor: a factor needs a copy constructor");
    static_assert(named,
                  "magimu: a factor has a residual: template <class T> Vec<T, rows> residual(const "
                  "Vec<T, n>& variable, ...) const");
    // Without variables Factor has said so.
    if constexpr (copied && named && F::AreVariables::value) return check_residual<F>();
  }
  return false;
}

// Pointers to the stored values of a factor's variables.
template <class F>
using Stored = std::array<const double*, std::size_t(F::kKeys)>;
template <class F>
using ResidualOf = Vec<double, F::kDim>;
template <class F>
using JacobianOf = Mat<double, F::kDim, F::kColumns>;

// The residual, not whitened.
template <class F>
ResidualOf<F> evaluate(const F& f, const Stored<F>& x) {
  return detail::residual_at(f, x, detail::kIndices<F>);
}

// Residual and Jacobian by automatic differentiation, not whitened.
template <class F>
ResidualOf<F> linearize_automatic(const F& f, const Stored<F>& x, JacobianOf<F>& J) {
  ResidualOf<F> r;
  for (int begin = 0; begin < F::kColumns; begin += detail::kAtATime) {
    const auto e = detail::residual_dual(f, x, begin, detail::kIndices<F>);
    for (int i = 0; i < F::kDim; ++i) {
      r[i] = e[i].v;
      for (int c = begin; c < std::min(begin + detail::kAtATime, F::kColumns); ++c) {
        J(i, c) = e[i].d[std::size_t(c - begin)];
      }
    }
  }
  return r;
}

// Residual and Jacobian, analytic where the factor has it, not whitened.
template <class F>
ResidualOf<F> linearize(const F& f, const Stored<F>& x, JacobianOf<F>& J) {
  if constexpr (detail::HasAnalyticJacobians<F>) {
    detail::JacobianTuple<F> parts;
    ResidualOf<F> r = detail::linearize_at(f, x, parts, detail::kIndices<F>);
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      ((J.template middleCols<VariableTraits<detail::VariableOf<F, I>>::kTangent>(
            detail::first_column<F, I>()) = std::get<I>(parts)),
       ...);
    }
    (detail::kIndices<F>);
    return r;
  } else {
    static_assert(!detail::NamesLinearize<F>,
                  "this factor's linearize() is not a template over the scalar that takes its "
                  "variables and one Jacobian a variable: it would never be called");
    return linearize_automatic(f, x, J);
  }
}

}  // namespace magimu
