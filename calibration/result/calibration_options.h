// SPDX-License-Identifier: BSD-3-Clause
// What a user may ask of a calibration (calibrate.h); the defaults serve recordings of a hand.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "calibration/start/initialize.h"
#include "solvers/linear/optimizer_options.h"

namespace magimu {

struct GivenPrior;  // parameter_prior.h

enum class PriorKind { kUsual, kNone, kGiven };

struct CalibrationOptions {
  // What is known before the recording: what is usual of parts, nothing, or `given_prior`.
  PriorKind prior = PriorKind::kUsual;
  std::shared_ptr<const GivenPrior> given_prior;
  // Noise densities, per sqrt(Hz); where nothing is given they are estimated from rests, then from
  // the residuals, and jolts are looked for that the accelerometer does not sample faithfully
  // (acc_jitter.h).
  std::optional<NoiseDensities> noise;
  double gravity = kStandardGravity;  // m/s^2
  // Did the sensor only turn, did a hand move it, or did it travel? kAuto: decided from the data,
  // and said.
  MotionModel motion = MotionModel::kAuto;
  // A lag of the magnetometer is estimated: always, never, or (nothing given) where the data show
  // one beyond four of its standard deviations.
  std::optional<bool> mag_time_offset;
  // Scale errors and misalignment of the gyroscope are estimated (not where the sensor only
  // turned): always, never, or (nothing given) where left-out samples of the magnetometer are
  // predicted better with them. So are the accelerometer's, and the gyroscope's response to
  // gravity, where the residuals show them; never: none of these.
  std::optional<bool> gyr_matrix;
  // Magnetometer samples a node; 0: every sample up to 100 Hz, above at most 40 nodes a second.
  // All samples are used in any case, as means about the nodes.
  int node_every = 0;
  InitializationOptions initialization;
  // Of the true dip: 1 on the northern hemisphere, -1 on the southern. It takes no part in the
  // estimate, but tells inverted axes from turned ones (check_axes.h). 0: unknown.
  int dip_sign = 0;
  OptimizerOptions optimizer;
  // Adds factors to every graph, such as what is known beforehand (field_check.h); none by default.
  std::function<void(FactorGraph&)> also = {};
  // Blocks of the robust covariance; longer than the residuals stay correlated.
  double block_s = 5.0;
  // Called with what is being done and how far the whole is (0 to 1), by one thread; may be empty.
  std::function<void(const std::string&, double)> progress = {};
};

}  // namespace magimu
