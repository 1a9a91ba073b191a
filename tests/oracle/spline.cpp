// SPDX-License-Identifier: BSD-3-Clause
// Quintic B-splines as one polynomial an interval: spline.h.
#include "tests/oracle/spline.h"

#include <cmath>

namespace magimu::oracle {
namespace {

// 120 times the six pieces of the cardinal B-spline that reach into an interval; row j belongs to
// the coefficient at knot j - 2 from the interval's start, column k to u^k.
Eigen::Matrix<double, 6, 6> basis() {
  Eigen::Matrix<double, 6, 6> m;
  m << 1, -5, 10, -10, 5, -1,    //
      26, -50, 20, 20, -20, 5,   //
      66, 0, -60, 0, 30, -10,    //
      26, 50, 20, -20, -20, 10,  //
      1, 5, 10, 10, 5, -5,       //
      0, 0, 0, 0, 0, 1;
  return m / 120.0;
}

}  // namespace

Spline::Spline(double interval_s, const std::vector<Eigen::Vector3d>& coefficients)
    : interval_(interval_s) {
  const int count = static_cast<int>(coefficients.size());
  const Eigen::Matrix<double, 6, 6> b = basis();
  for (int i = 0; i < count + 2; ++i) {
    Eigen::Matrix<double, 3, 6> near = Eigen::Matrix<double, 3, 6>::Zero();
    for (int k = 0; k < 6; ++k) {
      const int j = i - 2 + k;
      if (j >= 0 && j < count) near.col(k) = coefficients[static_cast<std::size_t>(j)];
    }
    pieces_.emplace_back(near * b);
  }
}

Eigen::Vector3d Spline::operator()(double t, int derivative) const {
  const double x = t / interval_;
  if (!(x >= 0.0) || x >= static_cast<double>(pieces_.size())) return Eigen::Vector3d::Zero();
  const auto i = static_cast<std::size_t>(x);
  const double u = x - static_cast<double>(i);
  const Eigen::Matrix<double, 3, 6>& c = pieces_[i];
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double scale = 1.0;
  for (int d = 0; d < derivative; ++d) scale /= interval_;
  for (int k = 5; k >= derivative; --k) {
    double factor = scale;
    for (int d = 0; d < derivative; ++d) factor *= k - d;
    sum = sum * u + factor * c.col(k);
  }
  return sum;
}

Spline Spline::scaled(double factor) const {
  Spline result = *this;
  for (auto& piece : result.pieces_) piece *= factor;
  return result;
}

}  // namespace magimu::oracle
