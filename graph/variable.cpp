// SPDX-License-Identifier: BSD-3-Clause
#include "graph/variable.h"

namespace magimu {

std::string to_string(VariableType type) {
  if (type.kind == 'R') return "Rot3";
  if (type.rows == 1 && type.cols == 1) return "double";
  if (type.cols == 1) return "Vector" + std::to_string(type.rows);
  return "Matrix" + std::to_string(type.rows) + "x" + std::to_string(type.cols);
}

void retract(VariableType type, const double* x, const double* delta, double* out) {
  if (type.kind == 'R') {
    const Rot3 R = VariableTraits<Rot3>::load<double>(x);
    const Vector3 d = Eigen::Map<const Vector3>(delta);
    VariableTraits<Rot3>::store((Rot3::Exp(d) * R).normalized(), out);
    return;
  }
  for (int i = 0; i < type.stored(); ++i) out[i] = x[i] + delta[i];
}

void local_coordinates(VariableType type, const double* x, const double* y, double* delta) {
  if (type.kind == 'R') {
    const Rot3 a = VariableTraits<Rot3>::load<double>(x);
    const Rot3 b = VariableTraits<Rot3>::load<double>(y);
    Eigen::Map<Vector3> d(delta);
    d = (b * a.inverse()).Log();
    return;
  }
  for (int i = 0; i < type.stored(); ++i) delta[i] = y[i] - x[i];
}

}  // namespace magimu
