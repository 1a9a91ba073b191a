// SPDX-License-Identifier: BSD-3-Clause
// Points spread evenly over what a magnetometer has read, for a picture: however many come in, a
// few hundred stay, none much closer to another than the rest. A new point takes the place of one
// that is too close, so that the picture is of now where the field has changed.
#pragma once

#include <limits>
#include <vector>

#include "graph/rot3.h"

namespace magimu::apps {

class PointNet {
 public:
  explicit PointNet(std::size_t most = 600) : most_(most) {}

  void add(const Vector3& point) {
    if (!point.allFinite()) return;
    latest_ = point;
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const double squared = (points_[k] - point).squaredNorm();
      if (squared >= least) continue;
      least = squared;
      nearest = k;
    }
    if (least < distance_ * distance_) {
      points_[nearest] = point;
      return;
    }
    points_.push_back(point);
    while (points_.size() > most_) thin();
  }

  const std::vector<Vector3>& points() const { return points_; }
  const Vector3& latest() const { return latest_; }

 private:
  // Points a quarter further apart: a surface then has room for two thirds of them.
  void thin() {
    constexpr double kWider = 1.25;
    distance_ = distance_ > 0.0 ? kWider * distance_ : kSmallest;
    std::vector<Vector3> kept;
    for (auto point = points_.rbegin(); point != points_.rend(); ++point) {  // the newest stay
      bool is_free = true;
      for (const Vector3& other : kept) {
        is_free = is_free && (other - *point).squaredNorm() >= distance_ * distance_;
      }
      if (is_free) kept.push_back(*point);
    }
    points_.assign(kept.rbegin(), kept.rend());
  }

  static constexpr double kSmallest = 0.01;  // uT, below the noise of any magnetometer

  std::size_t most_;
  double distance_ = 0.0;  // uT
  std::vector<Vector3> points_;
  Vector3 latest_ = Vector3::Zero();
};

}  // namespace magimu::apps
