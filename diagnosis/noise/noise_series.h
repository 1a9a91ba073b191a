// SPDX-License-Identifier: BSD-3-Clause
// One channel's residuals as the noise tests want them: evenly spaced (missing samples are zero and
// not in use), and cleaned of single samples that stick out, so that a few wild ones decide nothing
// about colour, lines and size.
#pragma once

#include <vector>

#include "diagnosis/noise/noise_tests.h"

namespace magimu {

struct NoiseSeries {
  Sensor channel = Sensor::kMag;
  double rate_hz = 0.0;
  double sigma = 0.0;  // as given or found at rest; 0: unknown
  bool sigma_given = false;
  bool high_passed = false;
  FitSpectrum of_white = {};
  double lag1_at_rest = 0.0, readings_at_rest = 0.0;
  std::vector<double> t;          // s, of every place of the grid
  std::vector<Vector3> reading;   // as recorded
  std::vector<Vector3> residual;  // zero where not in use
  std::vector<char> used;
  // Of each place in use, or empty: SampleResiduals.
  std::vector<Vector3> change;
  std::vector<Matrix3> to_n;

  std::size_t size() const { return t.size(); }
  std::size_t used_count() const;
  // A place of the grid, from now on without a sample.
  void drop(std::size_t k);
};

NoiseSeries make_noise_series(const SampleResiduals& residuals);

// Squared length of a sample, in units of the scales of high-passed residuals, beyond which it
// sticks out: one in 6000 of Gaussian ones does.
inline constexpr double kSticksOut = 20.0;
// And beyond which it is taken out of the cleaned residuals: so far out that its neighbours' noise
// does not decide about it. A choice that depends on neighbours would correlate the rest.
inline constexpr double kTakenOut = 80.0;

// What sticks out, found in the high-passed residuals.
struct Cleaned {
  std::vector<Vector3> residual;  // less `jump`; in the sensor's unit
  std::vector<Vector3> jump;      // by how much the wildest samples leave their neighbours; or zero
  std::vector<Vector3> own;       // high-passed residual without what other samples' jumps add
  Vector3 scale = Vector3::Ones();  // of `own`, each axis: standard deviation without the jumps
  double jump_fraction = 0.0;       // of the samples in use
};
Cleaned clean(const NoiseSeries& series);

// Standard deviation of Gaussian values among some that are not, each axis.
Vector3 robust_scale(const std::vector<Vector3>& values, const std::vector<char>& used);

}  // namespace magimu
