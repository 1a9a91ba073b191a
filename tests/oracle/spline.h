// SPDX-License-Identifier: BSD-3-Clause
// A smooth curve in continuous time: a uniform B-spline of degree five,
//
//   x(t) = sum_j c_j B5(t / h - j),
//
// four times continuously differentiable, exactly 0 wherever the six coefficients about t are 0,
// and exact in its derivatives. Both the rate and the displacement of a motion are such curves.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace magimu::oracle {

class Spline {
 public:
  // The zero curve.
  Spline() = default;
  // Coefficient j acts on (j - 3) h < t < (j + 3) h.
  Spline(double interval_s, const std::vector<Eigen::Vector3d>& coefficients);

  // The curve's derivative of that order, 0 to 3; 0 outside of the coefficients' reach and at t <
  // 0.
  Eigen::Vector3d operator()(double t, int derivative = 0) const;

  // The zero curve without coefficients.
  bool empty() const { return pieces_.empty(); }

  // The same curve times a factor.
  Spline scaled(double factor) const;

 private:
  double interval_ = 1.0;
  // Interval i holds t = (i + u) h: the polynomial in u, lowest power first.
  std::vector<Eigen::Matrix<double, 3, 6>> pieces_;
};

}  // namespace magimu::oracle
