// SPDX-License-Identifier: BSD-3-Clause
// A pack of doubles, one a lane, as a scalar for the templates of scalar.h. Included once for each
// instruction set, by a source file that is compiled for it and has defined
//
//   MAGIMU_ISA    the namespace of its code: baseline, avx2, avx512
//   MAGIMU_LANES  2, 4, 8
//
// Everything here lies in that namespace: objects that are compiled with different flags then have
// no function in common, of which the linker would keep one for all machines.
#pragma once

#include <Eigen/Core>

namespace magimu::MAGIMU_ISA {

inline constexpr int kLanes = MAGIMU_LANES;

struct Mask {
  using Raw [[gnu::vector_size(8 * MAGIMU_LANES)]] = long long;
  Raw m;
};

struct Pack {
  using Raw [[gnu::vector_size(8 * MAGIMU_LANES)]] = double;
  Raw v;

  Pack() = default;
  Pack(double x) : v(x - Raw{}) {}  // NOLINT(google-explicit-constructor): constants mix freely
  explicit Pack(Raw raw) : v(raw) {}

  Pack& operator+=(Pack b) { return *this = *this + b; }
  Pack& operator-=(Pack b) { return *this = *this - b; }
  Pack& operator*=(Pack b) { return *this = *this * b; }
  Pack& operator/=(Pack b) { return *this = *this / b; }
  friend Pack operator-(Pack a) { return Pack(-a.v); }
  friend Pack operator+(Pack a, Pack b) { return Pack(a.v + b.v); }
  friend Pack operator-(Pack a, Pack b) { return Pack(a.v - b.v); }
  friend Pack operator*(Pack a, Pack b) { return Pack(a.v * b.v); }
  friend Pack operator/(Pack a, Pack b) { return Pack(a.v / b.v); }
  friend Mask operator<(Pack a, Pack b) { return {a.v < b.v}; }
  friend Mask operator>(Pack a, Pack b) { return {a.v > b.v}; }
  friend Mask operator<=(Pack a, Pack b) { return {a.v <= b.v}; }
  friend Mask operator==(Pack a, Pack b) { return {a.v == b.v}; }
};

inline Pack select(Mask m, Pack a, Pack b) { return Pack(m.m ? a.v : b.v); }
inline Pack min(Pack a, Pack b) { return select(a < b, a, b); }
inline Pack max(Pack a, Pack b) { return select(a < b, b, a); }
inline Pack abs(Pack a) { return select(a < Pack(0.0), -a, a); }

inline Pack sqrt(Pack a) {
  Pack root;
  for (int i = 0; i < kLanes; ++i) root.v[i] = __builtin_sqrt(a.v[i]);
  return root;
}

// To the nearest whole number, below 2^51.
inline Pack round(Pack a) {
  const Pack big(6755399441055744.0);  // 1.5 * 2^52
  return (a + big) - big;
}

struct SineCosine {
  Pack sine, cosine;
};

// Taylor series on [-pi/4, pi/4], which end below rounding, after the argument has been reduced by
// quarter turns with pi / 2 in three parts. For angles up to about 1e5 rad.
inline SineCosine sine_cosine(Pack x) {
  const Pack quarters = round(x * Pack(0.63661977236758134308));
  // pi / 2 in parts: the first two have 33 bits each, so that their products are exact.
  const Pack r = ((x - quarters * Pack(1.57079632673412561417e+00)) -
                  quarters * Pack(6.07710050630396597660e-11)) -
                 quarters * Pack(2.02226624879595063154e-21);
  const Pack q = r * r;
  const Pack s =
      r + r * q *
              (-1.0 / 6 +
               q * (1.0 / 120 +
                    q * (-1.0 / 5040 +
                         q * (1.0 / 362880 +
                              q * (-1.0 / 39916800 +
                                   q * (1.0 / 6227020800 + q * (-1.0 / 1307674368000 +
                                                                q * (1.0 / 355687428096000))))))));
  const Pack c =
      1.0 +
      q * (-0.5 +
           q * (1.0 / 24 +
                q * (-1.0 / 720 +
                     q * (1.0 / 40320 + q * (-1.0 / 3628800 +
                                             q * (1.0 / 479001600 +
                                                  q * (-1.0 / 87178291200 +
                                                       q * (1.0 / 20922789888000 +
                                                            q * (-1.0 / 6402373705728000)))))))));
  // Quarter turns modulo 4: odd ones swap sine and cosine, halves change signs.
  const Pack half = round(quarters * Pack(0.5) - Pack(0.25));  // floor(quarters / 2)
  const Mask odd = quarters - half * Pack(2.0) > Pack(0.5);
  const Mask turned = abs(half - round(half * Pack(0.5) - Pack(0.25)) * Pack(2.0)) > Pack(0.5);
  const Pack sign = select(turned, Pack(-1.0), Pack(1.0));
  return {sign * select(odd, c, s), sign * select(odd, -s, c)};
}
inline Pack sin(Pack x) { return sine_cosine(x).sine; }
inline Pack cos(Pack x) { return sine_cosine(x).cosine; }

// A first guess to 1e-5 (Abramowitz and Stegun 4.4.49), then the angle that is left, by its sine.
inline Pack atan2(Pack y, Pack x) {
  const Pack ax = abs(x), ay = abs(y);
  const Pack large = max(ax, ay), safe = select(large > Pack(0.0), large, Pack(1.0));
  const Pack t = min(ax, ay) / safe, q = t * t;
  Pack a = t * (0.9998660 + q * (-0.3302995 + q * (0.1801410 + q * (-0.0851330 + q * 0.0208351))));
  a = select(ay > ax, Pack(1.57079632679489661923) - a, a);
  a = select(x < Pack(0.0), Pack(3.14159265358979323846) - a, a);
  a = select(y < Pack(0.0), -a, a);
  const SineCosine at = sine_cosine(a);
  const Pack xs = x / safe, ys = y / safe;
  const Pack d = (ys * at.cosine - xs * at.sine) / sqrt(max(xs * xs + ys * ys, Pack(1e-300)));
  return a + d * (1.0 + d * d * (1.0 / 6.0));
}

inline Pack load(const double* x) {
  Pack p;
  __builtin_memcpy(&p.v, __builtin_assume_aligned(x, 8 * MAGIMU_LANES), sizeof p.v);
  return p;
}
inline void store(Pack p, double* x) {
  __builtin_memcpy(__builtin_assume_aligned(x, 8 * MAGIMU_LANES), &p.v, sizeof p.v);
}

}  // namespace magimu::MAGIMU_ISA

namespace Eigen {
template <>
struct NumTraits<magimu::MAGIMU_ISA::Pack> : NumTraits<double> {
  using Real = magimu::MAGIMU_ISA::Pack;
  using NonInteger = magimu::MAGIMU_ISA::Pack;
  using Nested = magimu::MAGIMU_ISA::Pack;
  using Literal = double;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 0 };
  enum { ReadCost = 1, AddCost = 1, MulCost = 1 };
};
}  // namespace Eigen
