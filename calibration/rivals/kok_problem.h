// SPDX-License-Identifier: BSD-3-Clause
// The likelihood of Kok and Schoen (kok_filter.h) over one or several recordings of one device: a
// filter each, with parameters in common. Its unknowns are the parameters, a dip for each field,
// and, unless the start is held, the first orientation of each recording.
#pragma once

#include <vector>

#include "calibration/rivals/kok_filter.h"

namespace magimu {

// The unknowns at one point.
struct KokPoint {
  SensorParameters theta;       // its dip_rad is not used
  std::vector<double> dip_rad;  // one a field
  std::vector<Rot3> start;      // one a recording (or part of one)
};

struct KokProblemOptions {
  NoiseDensities noise;  // per sqrt(Hz)
  double gravity = kStandardGravity;
  // The first orientation is an unknown like the parameters, which presumes nothing of it, and the
  // filter begins with certainty. Else it is held, with the standard deviation start_sigma_rad.
  bool estimate_start = true;
  double start_sigma_rad = 0.0;
};

class KokProblem {
 public:
  KokProblem(const std::vector<const Recording*>& recordings, const KokProblemOptions& options);
  KokProblem(const KokProblem&) = delete;  // its filters refer to its steps
  KokProblem& operator=(const KokProblem&) = delete;

  // Parameters and dips, which come first in every vector; and with the starts.
  Eigen::Index parameters() const { return 6 + 12 * magnetometers_ + fields_; }
  Eigen::Index unknowns() const;

  KokSums run(const KokPoint& at) const;
  // J'J and J'w of the whitened innovations.
  KokSums linearize(const KokPoint& at, KokNormal& normal) const;
  KokPoint moved(const KokPoint& from, const VectorXd& step) const;
  std::vector<Rot3> orientations(const KokPoint& at, std::size_t recording) const;
  const std::vector<FilterStep>& steps(std::size_t recording) const { return steps_[recording]; }

 private:
  SensorParameters theta_of(const KokPoint& at, std::size_t recording) const;

  KokProblemOptions options_;
  Eigen::Index magnetometers_ = 0, fields_ = 0;
  std::vector<int> field_;
  std::vector<std::vector<FilterStep>> steps_;
  std::vector<KokFilter> filters_;
};

// 1/2 sum of e' S^-1 e and weight / 2 times the sum of log det S. Maximum likelihood: weight 1.
inline double kok_objective(const KokSums& sums, double weight = 1.0) {
  return 0.5 * (sums.squares + weight * sums.log_det);
}

}  // namespace magimu
