// SPDX-License-Identifier: BSD-3-Clause
// Does the magnetometer measure on a clock of its own, and is it read on another? Then a reading is
// up to T old, a sawtooth in the time (factors/effects/times/mag_own_clock.cpp), and the model,
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
  // The reading is held until the next one, as the effect has it; else readings are interpolated or
  // smoothed, and their ages are another function of the phase.
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

// Whether the residuals of a model with this clock (held readings) show no pattern of its period.
// (A model without the clock may have taken a slow part of the pattern into its attitudes.)
bool leaves_no_pattern(const OwnClock& clock, const SampleResiduals& mag, double level);

// Subtracts the clock's errors from the residuals, but for the mean age, which is the model's lag.
void take_out_own_clock(double period_s, double share, SampleResiduals& mag);

NoiseTest own_clock_test(const OwnClock& clock);

}  // namespace magimu
