// SPDX-License-Identifier: BSD-3-Clause
// What a simulation is asked to hide in its readings, and what it hid: effects by the names of
// docs/effects.md, with a size. Their equations are those of factors/effects/
// (sim/effect_readings.h adds them); here are their parameters:
//
//   lever_arm                    of a random realistic size, named by the seed
//   lever_arm=2                  twice that
//   lever_arm=0.05:0:0.02        r = (0.05, 0, 0.02) m
//   mag_lag=0.012:               a colon says that a single number is the parameter, not a factor
//   noise_scale@acc=1.5:         of that sensor's noise (acc, gyr or mag, which it is by default)
//
// A realistic size: each parameter of either sign and 0.1 to 0.3 of its prior's standard deviation,
// where the effect has such a prior. Beyond the parameters that a fit estimates there are those it
// searches for: the times of a change (t0, t1, s; infinite: lasting), the frequency of
// mains_interference (Hz). A drift of the gyroscope's bias has its density, linear_acceleration the
// root mean square of the displacement (it is the motion hand_held), and the noise-like effects
// have those of factors/effects/noise_effects.h.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "factors/effects/effect.h"

namespace magimu {

struct EffectRequest {
  std::string name;
  std::optional<Sensor> channel;  // of effects on the noise
  double factor = 1.0;            // on the realistic size
  std::vector<double> numbers;    // the parameters; empty: realistic ones
};

struct HiddenEffect {
  struct Parameter {
    std::string name, unit;
    double value;
  };
  std::string name;
  Sensor channel = Sensor::kMag;
  bool on_noise = false;  // one of those that any sensor's noise may have
  std::vector<Parameter> parameters;

  double operator[](std::size_t i) const { return parameters[i].value; }
};

// "NAME", "NAME=FACTOR", "NAME=V1:V2:...", "NAME@CHANNEL..."; throws InputError with a remedy.
EffectRequest parse_effect_request(const std::string& text);

// All names there are.
std::vector<std::string> hidden_effect_names();

// What the simulation that these numbers describe hides; throws InputError with a remedy.
struct SimulatedSurroundings {
  std::uint64_t seed = 1;
  double duration_s = 0.0;    // of the recording
  double strength_uT = 27.0;  // of the field
};
HiddenEffect hide(const EffectRequest& request, const SimulatedSurroundings& where);

// The effect with a term of its own, at its times or frequency; null: it has none (noise, a motion,
// the clock, a random walk).
std::shared_ptr<const Effect> term_of(const HiddenEffect& hidden);
// Its parameters, as many as the effect has.
VectorXd parameters_of(const HiddenEffect& hidden, const Effect& effect);

}  // namespace magimu
