// SPDX-License-Identifier: BSD-3-Clause
// A measured rotation between two poses, from a camera, a loop closure or a pose graph:
// r = Log(iRj' R_i' R_j).
#pragma once

#include "graph/factor_graph.h"

namespace magimu {

class RelativeRotationFactor : public Factor<3, Rot3, Rot3> {
 public:
  // iRj: rotates vectors of frame j into frame i.
  RelativeRotationFactor(Key nRi, Key nRj, const Rot3& iRj, const Noise<3>& noise)
      : Factor({nRi, nRj}, noise), jRi_(iRj.inverse()) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRi, const Rot3T<T>& nRj) const {
    return (jRi_.cast<T>() * (nRi.inverse() * nRj)).Log();
  }

  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRi, const Rot3T<T>& nRj, Mat3<T>& J_i, Mat3<T>& J_j) const {
    Vec3<T> r = residual(nRi, nRj);
    J_j = so3::right_jacobian_inverse(r) * nRj.matrix().transpose();
    J_i = -J_j;
    return r;
  }

 private:
  Rot3 jRi_;
};

// Compiled once, in factors.cpp.
extern template class FactorBatchOf<RelativeRotationFactor>;

}  // namespace magimu
