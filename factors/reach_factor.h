// SPDX-License-Identifier: BSD-3-Clause
// A hand, a stick or a robot's arm turns the sensor about a point that stays where it is, about:
//
//   r = p - R l - p_0        white, of the reach's standard deviation
//
// with the sensor at l from that point, in the IMU frame (the lever arm), and p_0 where the point
// is expected. Without l the position of a sensor on a stick, R l, passes for the double integral
// of a constant error of the accelerometer, -w^2 l where it turns at the rate w.
//
// Of a travelling sensor the same holds with velocities: v in the place of p, a steady velocity u
// along the sensor's own axes in that of l, p_0 = 0 (model.h).
#pragma once

#include "graph/factor_graph.h"

namespace magimu {

template <class S>
class ReachText {
 public:
  explicit ReachText(const Vec3<S>& middle) : middle_(middle) {}

  template <class T>
  Vec3<T> residual(const Rot3T<T>& nRb, const Vec3<T>& p, const Vec3<T>& lever_arm) const {
    return p - nRb.matrix() * lever_arm - middle_.template cast<T>();
  }

  // d r / d R = [R l]x,  d r / d p = I,  d r / d l = -R.
  template <class T>
  Vec3<T> linearize(const Rot3T<T>& nRb, const Vec3<T>& p, const Vec3<T>& lever_arm, Mat3<T>& J_R,
                    Mat3<T>& J_p, Mat3<T>& J_arm) const {
    const Vec3<T> arm_n = nRb.matrix() * lever_arm;
    J_R = so3::hat(arm_n);
    J_p.setIdentity();
    J_arm = -nRb.matrix();
    return p - arm_n - middle_.template cast<T>();
  }

  // The columns of p: an axis each.
  static constexpr bool is_zero(int row, int column) {
    return column >= 3 && column < 6 && column - 3 != row;
  }

 private:
  Vec3<S> middle_;
};

class ReachFactor : public Factor<3, Rot3, Vector3, Vector3>, public ReachText<double> {
 public:
  template <class S>
  using Text = ReachText<S>;

  // middle: of the turning point, in n, m; noise: m. With velocities all are in m/s.
  ReachFactor(Key nRb, Key p, Key lever_arm, const Vector3& middle, const Noise<3>& noise)
      : Factor({nRb, p, lever_arm}, noise), ReachText(middle) {}
};
template <>
inline constexpr bool kHasLanes<ReachFactor> = true;

}  // namespace magimu
