// SPDX-License-Identifier: BSD-3-Clause
// What the calibration tests share: simulated cases, options that tell the calibration what the
// simulation knows besides the parameters, and distances between calibrations in standard
// deviations.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "calibration/calibrate.h"
#include "sim/simulate.h"
#include "study/error_statistics.h"

namespace magimu::test {

inline Simulation simulated_hand(double rate_hz, std::uint64_t seed = 1, double duration_s = 0.0,
                                 int mag_ratio = 1, int magnetometers = 1) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = rate_hz;
  options.seed = seed;
  options.duration_s = duration_s;
  options.mag_ratio = mag_ratio;
  options.magnetometers = magnetometers;
  return simulate(options);
}

inline Simulation simulated_paper(double rate_hz, std::uint64_t seed = 1) {
  SimulationOptions options;
  options.rate_hz = rate_hz;
  options.seed = seed;
  return simulate(options);
}

// The model that the simulation follows, its noise estimated.
inline CalibrationOptions same_model(const Simulation& s, int node_every = 0) {
  CalibrationOptions options;
  options.gravity = s.truth.gravity;
  options.motion = MotionModel::kRotation;
  options.mag_time_offset = false;
  options.node_every = node_every;
  return options;
}

// The same with the true noise densities given.
inline CalibrationOptions same_model_and_noise(const Simulation& s, int node_every = 0) {
  CalibrationOptions options = same_model(s, node_every);
  options.noise = s.truth.noise;
  return options;
}

// The largest difference of two parameter vectors in a's model standard deviations.
inline double sigmas_apart(const Calibration& a, const VectorXd& b) {
  const VectorXd difference = in_calibration_order(a) - b;
  return (difference.array().abs() / a.covariance_model.diagonal().array().sqrt()).maxCoeff();
}

inline double sigmas_apart(const Calibration& a, const Calibration& b) {
  return sigmas_apart(a, in_calibration_order(b));
}

// The calibration converged, and its errors are those that its covariance speaks of: the NEES lies
// in the band that correct calibrations leave once in 150000.
inline void expect_consistent(const Calibration& c, const SensorParameters& truth) {
  constexpr double kWidth = 4.5;
  EXPECT_TRUE(c.fit.converged()) << c.fit.message;
  EXPECT_TRUE(c.undetermined.empty());
  const VectorXd e = parameter_error(c, truth);
  ASSERT_EQ(e.size(), c.covariance_model.rows());
  const Band band = chi_square_band(double(e.size()), kWidth);
  const double n = nees(e, c.covariance_model) / double(e.size());
  EXPECT_TRUE(band.contains(n))
      << "NEES / dof = " << n << ", expected between " << band.low << " and " << band.high
      << "; errors in sigma: "
      << (e.array() / c.covariance_model.diagonal().array().sqrt()).transpose();
}

}  // namespace magimu::test
