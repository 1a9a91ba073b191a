// SPDX-License-Identifier: BSD-3-Clause
// The spectrum of residuals and the models that are compared with it. Colour and size of the noise
// are judged from it above a lowest frequency only, because below it residuals hold what no noise
// model should answer for: slow drifts, errors that follow the orientation, the trajectory's
// bending towards the samples.
//
//   S(w) = G(w) (v (1 - rho^2) / (1 + rho^2 - 2 rho cos w) + b (w_min / w)^4)
//
// v the variance of AR(1) noise with rho between neighbours (rho = 0: white), b the tail of
// whatever is slow and smooth, G the squared gain of the high-pass filter where there is one, and
// of the fit (fit_spectrum.h). Means of periodograms are
// gamma-distributed, and nearly independent from one frequency to the next, so the fit is by
// Whittle's likelihood, sum looks (I / S + log S).
#pragma once

#include <vector>

#include "diagnosis/noise/noise_series.h"

namespace magimu {

// Periodograms of half-overlapping pieces (Welch 1967) of about 2.5 s with Hann's taper, all axes
// together, each in units of its noise; white noise: 1.
struct PieceSpectra {
  int length = 0;             // samples a piece
  std::vector<double> omega;  // rad a sample, from the lowest trusted frequency to Nyquist's
  std::vector<double> gain;   // G at omega; 1 without a high-pass
  std::vector<std::vector<double>> power;  // of every piece
  std::vector<double> activity;            // how much the model's reading changes in the piece
  Vector3 unit = Vector3::Ones();          // standard deviation that counts as 1, each axis
};
PieceSpectra piece_spectra(const NoiseSeries& series, const Cleaned& cleaned);

struct MeanSpectrum {
  std::vector<double> power;
  double looks = 0.0;  // independent periodogram ordinates in each
};
// Of all pieces, or of those chosen.
MeanSpectrum mean_spectrum(const PieceSpectra& spectra, const std::vector<char>& chosen = {});

struct ColourFit {
  double v = 0.0, rho = 0.0, b = 0.0;
  double log_v_sigma = 0.0, rho_sigma = 0.0;
  double log_likelihood = 0.0;  // up to a constant
};
ColourFit fit_white(const PieceSpectra& spectra, const MeanSpectrum& mean);
ColourFit fit_correlated(const PieceSpectra& spectra, const MeanSpectrum& mean);
// With rho held.
ColourFit fit_levels(const PieceSpectra& spectra, const MeanSpectrum& mean, double rho);
// Of the spectrum under a model that was fitted elsewhere.
double log_likelihood(const PieceSpectra& spectra, const MeanSpectrum& mean,
                      const ColourFit& model);

}  // namespace magimu
