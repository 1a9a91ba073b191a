// SPDX-License-Identifier: BSD-3-Clause
// What is known of one variable beforehand: for vectors and matrices r = x - x0; for a rotation
// r = Log(R R0'), the increment from the left that leads from R0 to R.
#pragma once

#include "graph/factor_graph.h"

namespace magimu {

template <class V, class S>
class PriorText {
  static constexpr int kN = VariableTraits<V>::kTangent;

 public:
  explicit PriorText(const Rebind<V, S>& mean) : mean_(mean) {}

  template <class T>
  Vec<T, kN> residual(const Rebind<V, T>& x) const {
    if constexpr (std::is_same_v<V, double>) {
      return Vec<T, 1>(x - T(mean_));
    } else {
      return (x - mean_.template cast<T>()).reshaped();
    }
  }

  template <class T>
  Vec<T, kN> linearize(const Rebind<V, T>& x, Mat<T, kN, kN>& J) const {
    J.setIdentity();
    return residual<T>(x);
  }

 private:
  Rebind<V, S> mean_;
};

template <class V>
class PriorFactor : public Factor<VariableTraits<V>::kTangent, V>, public PriorText<V, double> {
  static constexpr int kN = VariableTraits<V>::kTangent;

 public:
  template <class S>
  using Text = PriorText<V, S>;

  PriorFactor(Key key, const V& mean, const Noise<kN>& noise)
      : Factor<kN, V>({key}, noise), PriorText<V, double>(mean) {}
};
template <>
inline constexpr bool kHasLanes<PriorFactor<Vector3>> = true;

template <>
class PriorFactor<Rot3> : public Factor<3, Rot3> {
 public:
  PriorFactor(Key key, const Rot3& mean, const Noise<3>& noise)
      : Factor({key}, noise), mean_inverse_(mean.inverse()) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& R) const {
    return (R * mean_inverse_.cast<T>()).Log();
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& R, Mat3<T>& J) const {
    Vec3<T> r = residual(R);
    J = so3::left_jacobian_inverse(r);
    return r;
  }

 private:
  Rot3 mean_inverse_;
};

// Compiled once, in factors.cpp.
extern template class FactorBatchOf<PriorFactor<double>>;
extern template class FactorBatchOf<PriorFactor<Vector3>>;
extern template class FactorBatchOf<PriorFactor<Rot3>>;

}  // namespace magimu
