// SPDX-License-Identifier: BSD-3-Clause
// How steady a direction stands when a gyroscope with given axes turns it to one frame: the test of
// one hypothesis of mounting.h.
#pragma once

#include <vector>

#include "calibration/motion/integrated_rotation.h"

namespace magimu {

class DirectionSteadiness {
 public:
  // gyr: outlives this. directions: of any length, in the frame of their sensor. gyr_bias, rad/s.
  DirectionSteadiness(const VectorSeries& gyr, const Vector3& gyr_bias,
                      const VectorSeries& directions);

  // Pairs of times between which the sensor has turned enough to tell anything.
  std::size_t pairs() const { return pairs_.size(); }

  // Root mean square angle between the directions of each pair, rad, had the gyroscope read
  // gyr_axes times what it did (a signed permutation).
  double rms_rad(const Matrix3& gyr_axes) const;

 private:
  struct Pair {
    std::size_t first_i, last_i, first_j, last_j;  // samples averaged at both times
  };
  VectorSeries mirrored_;                      // the gyroscope's rates, all reversed
  std::vector<Matrix3> turn_, mirrored_turn_;  // sensor to start, at every sample of directions
  const VectorSeries& directions_;
  std::vector<Pair> pairs_;
};

}  // namespace magimu
