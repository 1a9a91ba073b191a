// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/model/exact_symmetries.h"

#include <Eigen/LU>

#include <cmath>

#include "calibration/model/model.h"

namespace magimu {

void fix_symmetries(Values& values, int magnetometers, const std::vector<NodePlan>& plans) {
  const int fields = plans.back().field + 1;
  const Rot3 half_turn = Rot3::from_unit_quaternion(Vector4(0.0, 0.0, 0.0, 1.0));
  const auto turn = [&](const NodePlan& plan) {
    for (int k = 0; k < int(plan.t.size()); ++k) {
      const int id = plan.first + k;
      values.update(R(id), half_turn * values.at<Rot3>(R(id)));
      if (!values.contains(V(id))) continue;
      values.update(V(id), Vector3(half_turn * values.at<Vector3>(V(id))));
      values.update(P(id), Vector3(half_turn * values.at<Vector3>(P(id))));
    }
  };
  if (values.at<Matrix3>(key::distortion).determinant() < 0.0) {
    for (int m = 0; m < magnetometers; ++m) {
      values.update(key::distortion_of(m), Matrix3(-values.at<Matrix3>(key::distortion_of(m))));
    }
    for (int f = 0; f < fields; ++f) {
      values.update(dip_of(f), -values.at<double>(dip_of(f)));
    }
    for (const NodePlan& plan : plans) turn(plan);
  }
  for (int f = 0; f < fields; ++f) {
    double dip = std::remainder(values.at<double>(dip_of(f)), 2.0 * M_PI);
    if (std::cos(dip) < 0.0) {
      dip = std::remainder(M_PI - dip, 2.0 * M_PI);
      for (const NodePlan& plan : plans) {
        if (plan.field == f) turn(plan);
      }
    }
    values.update(dip_of(f), dip);
  }
}

}  // namespace magimu
