// SPDX-License-Identifier: BSD-3-Clause
// Does the magnetometer measure on a clock of its own, and is it read on another? Then what is read
// is up to T old, a sawtooth in the time (factors/effects/times/mag_own_clock.cpp), and the model,
// which has one lag for all samples, leaves
//
//   e_k = (mean age - T frac(t_k / T + p)) d_k + noise,   d_k = d reading / dt.
//
// So d_k' e_k has a line, of the sawtooth's frequency as the samples show it (folded about their
// rate) and nowhere else: a field that alternates has one across the change as well. The
// periodogram finds the line; of the periods that fold to it, that which explains the most is the
// clock's, as the sawtooth's height is its period.
#pragma once

#include <optional>

#include "diagnosis/noise/noise_tests.h"

namespace magimu {

struct OwnClock {
  double period_s = 0.0, share = 0.0;  // T and p
  double period_sigma_s = 0.0, share_sigma = 0.0;
  // Held until the next one, as the effect has it; else what is read is interpolated or smoothed,
  // and the ages are another function of the phase.
  bool held = true;
  double reach_s = 0.0;    // how much older or newer than its time a sample is
  double pattern_s = 0.0;  // after which the samples' ages repeat: as the samples show it
  double p_value = 1.0;    // of the line, among all frequencies
  // Nats of the samples' change, alternate stretches of ten seconds predicted from the others.
  double nll_before = 0.0, nll_after = 0.0;
};

// Of a magnetometer's samples, whose change is known; nothing where they show no clock.
// level: of p_value.
std::optional<OwnClock> find_own_clock(const SampleResiduals& mag, double level);

// Whether nothing of its pattern is left where the model has the clock, as one that holds what it
// measured. A model without it may have taken up a part: what folds to slow times.
bool leaves_no_pattern(const OwnClock& clock, const SampleResiduals& mag, double level);

// What the clock leaves of the samples, its mean age apart, which a lag has taken.
void take_out_own_clock(double period_s, double share, SampleResiduals& mag);

NoiseTest own_clock_test(const OwnClock& clock);

}  // namespace magimu
