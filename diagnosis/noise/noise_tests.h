// SPDX-License-Identifier: BSD-3-Clause
// Causes that change the noise rather than the reading: its size, its colour, its tails, steps of
// the converter, clipping, mains. Each is tested on the residuals of single samples, where its null
// distribution is known or simulated, and has its own likelihood.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/noise/fit_spectrum.h"
#include "diagnosis/result/diagnosis.h"
#include "factors/effects/noise_effects.h"
#include "recording/data/recording.h"

namespace magimu {

// One sensor's samples with what the fitted model leaves of them.
struct SampleResiduals {
  Sensor channel = Sensor::kMag;
  std::vector<double> t = {};          // s
  std::vector<Vector3> reading = {};   // as recorded
  std::vector<Vector3> residual = {};  // reading less the model's; in the sensor's unit
  // How fast the model's reading changes, units per s, and how fast it would if the sensor turned
  // as fast about the axis across; empty where the model follows the reading.
  std::vector<Vector3> change = {}, across = {};
  // Where the sensor rests: the correlation of its readings with their neighbours, and of how many.
  // 0 readings: it has no rests, or its steps are coarser than its noise.
  double lag1_at_rest = 0.0, readings_at_rest = 0.0;
  // What turns the sensor's readings of a field to n, of each sample, where that is known.
  std::vector<Matrix3> to_n = {};
  double sigma = 0.0;  // of one sample, as given or found at rest; 0: unknown
  bool sigma_given = false;
  // The trajectory follows this sensor's samples, so that residual holds only what is faster than
  // it: slower noise does not show.
  bool high_passed = false;
  FitSpectrum of_white = {};  // elsewhere: what white noise leaves
};

struct NoiseTest {
  std::string effect =
      {};  // "noise_scale", "correlated_noise", "outliers", "mag_quantization", ...
  Sensor channel = Sensor::kMag;
  double statistic = 0.0;
  int dof = 1;
  double p_value = 1.0;  // of this test alone
  // s; rho; eps and K; q; M; a_x, a_y, a_z, d_x, d_y, d_z (of the room: a_n_x, ...) and f (as
  // sampled: from 0 to half the sampling rate). Empty, or without standard deviations, where
  // nothing is seen.
  std::vector<FoundParameter> parameters = {};
  std::string sentence = {};  // "One in 80 samples of the magnetometer is an outlier, ..."
  // Why it could not be tested, or why what was seen is not this; then p_value is 1.
  std::string untested = {};
  // Of outliers: they come several at a time, as blows do; then they are no outliers.
  bool in_bursts = false;
  // Of mains: the lines that were likelier, and are the motion's.
  std::vector<Mains> of_motion = {};
  // Negative log-likelihood of the residuals, up to a constant, by halves of the recording:
  // parameters from one half judged on the other, without and with this cause (mains: by alternate
  // stretches of 5 s). The finding's held-out gain. 0 where nothing is seen.
  double nll_before = 0.0, nll_after = 0.0;
};

// The step of a magnetometer whose converter is coarse beside its noise, uT, from its readings
// alone; 0: it is not.
double coarse_step(const VectorSeries& mag);

// All noise-like causes on all channels. They are not told apart here: outliers raise the size,
// too. `explain_noise` does that.
std::vector<NoiseTest> test_noise(const std::vector<SampleResiduals>& channels);

// The causes with p below `level` when each is tested on what those before it leave: saturation
// (its samples are left out), quantization (what rounding alone imitates is not named below),
// mains (subtracted), outliers (taken out), correlated_noise, noise_scale (of the noise as it is
// then known to be). Slow errors, errors that come with the motion, steps and passing magnets are
// named by none of them.
std::vector<NoiseTest> explain_noise(const std::vector<SampleResiduals>& channels, double level);

}  // namespace magimu
