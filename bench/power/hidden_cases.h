// SPDX-License-Identifier: BSD-3-Clause
// Recordings in which something is hidden, for bench_diagnosis_power and the tests of diagnosis/:
// an effect of docs/effects.md, two, none, or one from outside of the catalogue, each with a random
// device, motion, rate, noise and duration, all from a seed. The recordings come from the tests'
// oracle, which shares nothing with the models that look for the effect.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/power/true_parameters.h"
#include "diagnosis/result/diagnosis.h"
#include "tests/oracle/sensors.h"

namespace magimu {

struct HiddenCase {
  std::uint64_t seed = 1;
  std::vector<std::string> hidden;  // what is to be named
  oracle::Options options;          // its effects are those hidden; linear_acceleration is a motion
  // One a hidden effect: sqrt(theta' A theta), see effect_sizes.h; 0: not measured.
  std::vector<double> sizes;
  // Noise densities are told to the diagnosis, as a data sheet would; otherwise it finds them.
  bool noise_given = true;
  // How far the hidden effects shift the calibration that does not know them: the largest shift of
  // a parameter in its standard deviations.
  double bias_sigma = 0.0;

  bool moved() const { return options.motion.kind == oracle::MotionKind::kHandHeld; }
};

// Everything that can be hidden: the oracle's catalogue and "linear_acceleration".
std::vector<std::string> hidden_effects();

// One effect of realistic strength. The auxiliary columns that it needs are recorded; the motion is
// one that can show it: lever_arm where the sensor only turns (a hand's motion absorbs it),
// field_gradient and stationary_source where it is moved.
HiddenCase draw_case(const std::string& effect, std::uint64_t seed);

// Two effects of different kinds.
HiddenCase draw_pair(std::uint64_t seed);

// Nothing, with noise of these kinds in all channels.
enum class NoiseKind { kWhite, kColoured, kHeavyTailed };
std::string to_string(NoiseKind kind);
HiddenCase draw_none(NoiseKind noise, std::uint64_t seed);

// The densities are the true ones where the case tells them.
DiagnosisOptions diagnosis_options(const HiddenCase& hidden_case);

// Another recording of the same device with the same effects: new motion and noise, same length.
oracle::Options second_recording(const HiddenCase& hidden_case);

// A number in [0, 1) that belongs to this seed and purpose.
double draw(std::uint64_t seed, int purpose);

}  // namespace magimu
