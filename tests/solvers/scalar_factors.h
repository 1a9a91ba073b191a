// SPDX-License-Identifier: BSD-3-Clause
// Small users' factors from lambdas: a residual of one or two scalars, differentiated
// automatically.
//
//   graph.add(residual(x, [](auto v) { return v * v - 2.0; }));
#pragma once

#include "graph/factor_graph.h"

namespace magimu::test {

constexpr Key x_key(int i) { return {'x', std::uint32_t(i)}; }

template <class Function>
class OneScalar : public Factor<1, double> {
 public:
  OneScalar(Key a, const Function& f, const Noise<1>& noise) : Factor({a}, noise), f_(f) {}
  template <class T>
  Vec<T, 1> residual(const T& a) const {
    return Vec<T, 1>(f_(a));
  }

 private:
  Function f_;
};

template <class Function>
class TwoScalars : public Factor<1, double, double> {
 public:
  TwoScalars(Key a, Key b, const Function& f, const Noise<1>& noise)
      : Factor({a, b}, noise), f_(f) {}
  template <class T>
  Vec<T, 1> residual(const T& a, const T& b) const {
    return Vec<T, 1>(f_(a, b));
  }

 private:
  Function f_;
};

template <class Function>
auto residual(Key a, const Function& f, const Noise<1>& noise = {}) {
  return OneScalar<Function>(a, f, noise);
}
template <class Function>
auto residual(Key a, Key b, const Function& f, const Noise<1>& noise = {}) {
  return TwoScalars<Function>(a, b, f, noise);
}

inline Values scalars(std::initializer_list<double> numbers) {
  Values v;
  for (const double x : numbers) v.insert(x_key(v.size()), x);
  return v;
}

}  // namespace magimu::test
