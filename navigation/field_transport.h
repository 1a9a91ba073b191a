// SPDX-License-Identifier: BSD-3-Clause
// The coefficients of a field model seen from a body that has moved. The model of field_basis.h in
// the old body frame is F; after a displacement d (old frame) and a turn E (new to old frame) the
// same field in the new frame is E' F(E r + d). The space of models is closed under displacements
// and turns, so the new coefficients are exact:
//
//   theta_new = A^+ B theta,  A = stack Phi(c_i),  B = stack E' Phi(E c_i + d)
//
// for any fixed points c_i that make A's columns independent.
#pragma once

#include <vector>

#include "factors/field_basis.h"
#include "graph/rot3.h"

namespace magimu {

class FieldTransport {
 public:
  explicit FieldTransport(int order);

  const FieldBasis& basis() const { return basis_; }

  // A^+ B, kappa x kappa.
  MatrixXd matrix(const Rot3& E, const Vector3& d) const;

  struct Moved {
    MatrixXd by_theta;       // A^+ B
    VectorXd theta;          // in the new frame
    MatrixXd by_d, by_turn;  // kappa x 3: by the displacement; by e of the turn E Exp(e)
  };
  Moved move(const VectorXd& theta, const Rot3& E, const Vector3& d) const;

 private:
  FieldBasis basis_;
  std::vector<Vector3> points_;
  MatrixXd solve_;  // A^+
};

}  // namespace magimu
