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
// clock's, as the sawtooth's height is its period. Where both clocks nearly agree the pattern is as
// slow as the motion: there the sawtooth itself is looked for, at every frequency. The attitudes
// have taken a part of its height, so that a fit with each clock decides which it is.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/noise/noise_tests.h"

namespace magimu {

inline constexpr double kSlowPattern = 0.5;  // s: as slow as a hand's motion and the model's errors

struct OwnClock {
  double period_s = 0.0, share = 0.0;  // T and p
  double period_sigma_s = 0.0, share_sigma = 0.0;
  // The reading is held until the next one, as the effect has it; else readings are interpolated or
  // smoothed, and their ages are another function of the phase.
  bool held = true;
  double reach_s = 0.0;    // how much older or newer than its time a sample is
  double pattern_s = 0.0;  // after which the samples' ages repeat: as the samples show it
  bool is_slow() const { return pattern_s > kSlowPattern; }
  double p_value = 1.0;  // of the line, or of the slow sawtooth, among all frequencies
  // The samples alone do not show that it is a clock: a fit must be better with it by so many nats.
  double needed_nats = 0.0;
  // Nats of the samples' change, alternate stretches of ten seconds predicted from the others; of a
  // clock that fits decided, of the fit.
  double nll_before = 0.0, nll_after = 0.0;
};

// Of a magnetometer's samples, whose change is known: clocks that are possible, first that of the
// line. level: of p_value.
std::vector<OwnClock> find_own_clocks(const SampleResiduals& mag, double level);

// The one that the samples show by themselves.
std::optional<OwnClock> find_own_clock(const SampleResiduals& mag, double level);

// The same clock, told by the residuals of a model that has it: of which the attitudes have taken
// nothing.
OwnClock told_anew(const OwnClock& clock, SampleResiduals mag);

// What ages that are any function of the clock's phase explain of such residuals, beyond what they
// explain of white noise. Nats.
double pattern_left(const OwnClock& clock, const SampleResiduals& mag);

// Whether the residuals of a model with this clock (held readings) show no pattern of its period.
// (A model without the clock may have taken a slow part of the pattern into its attitudes.)
bool leaves_no_pattern(const OwnClock& clock, const SampleResiduals& mag, double level);

// Subtracts the clock's errors from the residuals, but for the mean age, which is the model's lag.
void take_out_own_clock(double period_s, double share, SampleResiduals& mag);

NoiseTest own_clock_test(const OwnClock& clock);

}  // namespace magimu
