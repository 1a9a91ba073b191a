// SPDX-License-Identifier: BSD-3-Clause
// A displacement drawn from a seed and scaled to its size: hand_displacement.h.
#include "sim/motions/hand_displacement.h"

#include <cmath>

#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kDisplacementInterval = 0.5;        // s, the least
constexpr double kCorrelation = 0.7;                 // of neighbouring coefficients
constexpr double kLeastRms = 0.05, kMostRms = 0.30;  // m, RMS
constexpr double kStep = 0.05;                       // s, where the size is measured

double mean_square(const Spline& spline, double& seconds) {
  double sum = 0.0;
  for (double t = spline.start; t < spline.end; t += kStep) {
    sum += spline.at(t).squaredNorm() * kStep;
    seconds += kStep;
  }
  return sum;
}

}  // namespace

HandDisplacement::HandDisplacement(std::uint64_t seed, const std::vector<Spline>& stretches,
                                   double rms_m) {
  RandomStream random(seed, RandomPurpose::kDisplacement);
  const double drawn = random.uniform(kLeastRms, kMostRms);
  double squares = 0.0, seconds = 0.0;
  for (const Spline& stretch : stretches) {
    Spline spline{stretch.start, stretch.end, {}};
    Vector3 c = random.normal3();
    for (int j = Spline::room(stretch.end - stretch.start, kDisplacementInterval); j > 0; --j) {
      spline.coefficient.push_back(c);
      c = kCorrelation * c + std::sqrt(1.0 - kCorrelation * kCorrelation) * random.normal3();
    }
    squares += mean_square(spline, seconds);
    splines_.push_back(std::move(spline));
  }
  if (!(squares > 0.0)) return;
  const double scale = (rms_m < 0.0 ? drawn : rms_m) / std::sqrt(squares / seconds);
  for (Spline& spline : splines_) {
    for (Vector3& c : spline.coefficient) c *= scale;
  }
}

Vector3 HandDisplacement::at(double t, int derivative) const {
  for (const Spline& spline : splines_) {
    if (t > spline.start && t < spline.end) return spline.at(t, derivative);
  }
  return Vector3::Zero();
}

}  // namespace magimu
