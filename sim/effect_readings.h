// SPDX-License-Identifier: BSD-3-Clause
// Adds hidden effects to exact readings: each effect's term (factors/effects/) of what the sensor
// truly experiences at that instant, attitude, rate and force of the motion in continuous time. The
// gyroscope's terms are means over its interval, by Gauss's rule with three points. The random walk
// of its bias is a true one: independent steps from sample to sample, and within an interval the
// mean of a walk differs at random from the mean of its two ends.
//
// Terms add up. Each is computed from the basic models' state, so that what two effects do to each
// other (eddy currents in a drifting field) is left out.
#pragma once

#include <optional>

#include "factors/effects/noise_effects.h"
#include "sim/simulate.h"
#include "sim/true_motion.h"

namespace magimu {

// Adds the terms, and the columns that a diagnosis of them needs: temp (a device that warms up),
// current (a load switched on and off) and pos. A source of a field that was drawn, not given, is
// moved away from the sensor's path.
void add_effects(const SimulationOptions& options, const TrueMotion& motion, SimulationTruth& truth,
                 Recording& recording);

// What magnetometers that stand side by side (in the order of the recording) carry on to each other
// of what they read, noise included.
void add_coupling(const std::vector<HiddenEffect>& effects, std::vector<VectorSeries>& mags);

// The shape of a sensor's noise; none where no effect changes it.
std::optional<NoiseShape> noise_shape(const std::vector<HiddenEffect>& effects, Sensor channel);
// Quantization and clipping of a magnetometer's samples.
void convert_to_digital(const std::vector<HiddenEffect>& effects, VectorSeries& mag);

// The columns' profiles, of true time, s: K and A.
double warming_device(double t);
double switched_load(double t);

}  // namespace magimu
