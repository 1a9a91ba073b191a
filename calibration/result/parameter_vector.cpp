// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/result/parameter_vector.h"

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace magimu {
namespace {

// Calls f with each number of the vector, in its order.
template <class C, class F>
void for_each_parameter(C& c, const F& f) {
  for (int i = 0; i < 3; ++i) f(c.parameters.acc_bias[i]);
  for (int i = 0; i < 3; ++i) f(c.parameters.gyr_bias[i]);
  for (auto& mag : c.parameters.mag) {
    for (int i = 0; i < 9; ++i) f(mag.distortion(i % 3, i / 3));
    for (int i = 0; i < 3; ++i) f(mag.bias[i]);
  }
  for (auto& field : c.fields) f(field.dip_rad);
  for (auto& effect : c.effects) {
    for (auto& p : effect.parameters) f(p.value);
  }
}

Eigen::Index first_dip(const Calibration& c) {
  return 6 + 12 * Eigen::Index(c.parameters.mag.size());
}

}  // namespace

VectorXd parameter_vector(const Calibration& c) {
  std::vector<double> all;
  for_each_parameter(c, [&](double value) { all.push_back(value); });
  VectorXd theta = Eigen::Map<const VectorXd>(all.data(), Eigen::Index(all.size()));
  theta.segment(first_dip(c), Eigen::Index(c.fields.size())) /= kDegree;
  return theta;
}

void set_parameters(Calibration& c, const VectorXd& theta) {
  VectorXd stored = theta;
  stored.segment(first_dip(c), Eigen::Index(c.fields.size())) *= kDegree;
  Eigen::Index at = 0;
  for_each_parameter(c, [&](double& value) { value = stored[at++]; });
  c.parameters.dip_rad = c.fields.front().dip_rad;
  c.strength_uT = std::cbrt(c.parameters.mag.front().distortion.determinant());
}

Values as_globals(const Calibration& c, const std::vector<Key>& keys, const VectorXd& theta) {
  Values out;
  VectorXd stored = theta;
  stored.segment(first_dip(c), Eigen::Index(c.fields.size())) *= kDegree;
  Eigen::Index at = 0;
  for (const Key key : keys) {
    const VariableType type = c.fit.values.slot(key).type;
    const int n = type.tangent();
    if (type == VariableTraits<double>::type()) {
      out.insert(key, double(stored[at]));
    } else if (type == VariableTraits<Vector3>::type()) {
      out.insert(key, Vector3(stored.segment<3>(at)));
    } else if (type == VariableTraits<Matrix3>::type()) {
      out.insert(key, Matrix3(stored.segment<9>(at).reshaped(3, 3)));
    } else if (type == VariableTraits<GyroMatrix>::type()) {
      out.insert(key, GyroMatrix(stored.segment<9>(at)));
    } else {
      throw std::logic_error("a parameter of another type");
    }
    at += n;
  }
  return out;
}

}  // namespace magimu
