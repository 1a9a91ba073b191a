// SPDX-License-Identifier: BSD-3-Clause
// Noise that is correlated in time, and noise of another size than given: both from the spectrum.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/noise/noise_causes.h"
#include "diagnosis/result/sentence_words.h"
#include "statistics/quantiles.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

// Relative. Residuals may be so much smaller than the given noise: a fit takes degrees of freedom,
// and a strong slow error takes some of the noise with it.
constexpr double kLessBy = 0.06;
constexpr double kBeyondChance = 3.0;  // standard deviations by which it is less at rest
constexpr double kLooked = 0.05;       // p below which a colour is looked at in halves
constexpr double kContradict = 16.0;   // chi-square of one degree of freedom: one in 16,000
constexpr double kOpposite = 1e-4;     // p of a negative correlation that is told

std::vector<char> first_half(const PieceSpectra& spectra, bool other) {
  std::vector<char> chosen(spectra.power.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = (2 * i < chosen.size()) != other;
  return chosen;
}

// The pieces in which the reading changes least, or the others.
std::vector<char> quiet_half(const PieceSpectra& spectra, bool other) {
  const double middle = quantile(spectra.activity, 0.5);
  std::vector<char> chosen(spectra.power.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    chosen[i] = (spectra.activity[i] < middle) != other;
  }
  return chosen;
}

using Halves = std::array<MeanSpectrum, 2>;

Halves halves(const PieceSpectra& s, std::vector<char> (*half)(const PieceSpectra&, bool)) {
  return {mean_spectrum(s, half(s, false)), mean_spectrum(s, half(s, true))};
}

// Noise is the same sensor's in every part of the recording; an error that comes with the motion
// is not. Each part has its own level, and must agree with the common correlation.
bool same_in_both(const PieceSpectra& s, const Halves& parts, double rho) {
  double disagreement = 0.0;
  for (const MeanSpectrum& part : parts) {
    const double common = fit_levels(s, part, rho).log_likelihood;
    if (common < fit_levels(s, part, 0.0).log_likelihood - 2.0) return false;
    disagreement += 2.0 * (fit_correlated(s, part).log_likelihood - common);
  }
  return disagreement < kContradict;
}

// Relative standard deviation of the level, from how it changes from piece to piece: more than
// that of Gaussian noise where tails are heavy. From the upper half of the band, which is clear of
// what is slow, and has half of the ordinates; overlapping pieces share some of their scatter.
double level_scatter(const PieceSpectra& spectra) {
  constexpr double kOverlap = 1.086;
  double sum = 0.0, square = 0.0;
  for (const std::vector<double>& power : spectra.power) {
    double level = 0.0;
    for (std::size_t j = power.size() / 2; j < power.size(); ++j)
      level += power[j] / spectra.gain[j];
    sum += level;
    square += level * level;
  }
  const double m = double(spectra.power.size());
  return std::sqrt(std::max(0.0, m * square / (sum * sum) - 1.0) * 0.5 * kOverlap / m);
}

// Coloured noise is coloured at rest, too. Where the trajectory follows the sensor, fast turns that
// are sampled slowly leave residuals that look coloured, but only in motion.
bool rests_contradict(const NoiseSeries& s, const ColourFit& ar) {
  if (s.readings_at_rest == 0.0) return false;
  const double sigma =
      std::hypot(ar.rho_sigma, std::sqrt((1.0 - ar.rho * ar.rho) / s.readings_at_rest));
  return ar.rho - s.lag1_at_rest > kBeyondChance * sigma;
}

}  // namespace

NoiseTest test_correlated_noise(const NoiseSeries& s, const PieceSpectra& spectra) {
  NoiseTest test;
  test.effect = "correlated_noise";
  test.channel = s.channel;
  const MeanSpectrum mean = mean_spectrum(spectra);
  const ColourFit white = fit_white(spectra, mean), ar = fit_correlated(spectra, mean);
  test.statistic = std::max(0.0, 2.0 * (ar.log_likelihood - white.log_likelihood));
  test.p_value = 0.5 * chi_square_tail(test.statistic, 1);
  // Sensors' filters make neighbours alike, none makes them opposite.
  if (ar.rho <= 0.0) {
    if (test.p_value < kOpposite)
      test.untested =
          "neighbouring samples are opposite rather than alike, which no filter makes them";
    test.p_value = 1.0;
  }
  const Halves in_time = halves(spectra, first_half);
  for (std::size_t i = 0; i < 2; ++i) {
    test.nll_before -= log_likelihood(spectra, in_time[i], fit_white(spectra, in_time[1 - i]));
    test.nll_after -= log_likelihood(spectra, in_time[i], fit_correlated(spectra, in_time[1 - i]));
  }
  test.parameters = {{"rho", ar.rho, ar.rho_sigma, ""}};
  if (test.p_value < kLooked && !(same_in_both(spectra, in_time, ar.rho) &&
                                  same_in_both(spectra, halves(spectra, quiet_half), ar.rho))) {
    test.p_value = 1.0;
    test.untested =
        "the correlation of neighbouring samples changes within the recording, so it is "
        "an error of the model rather than noise";
  }
  if (test.p_value < kLooked && rests_contradict(s, ar)) {
    test.p_value = 1.0;
    test.untested =
        "where the sensor rests neighbouring samples are less alike, so it is what the motion "
        "leaves rather than noise";
  }
  test.sentence = fmt::format(
      "The noise of the {} is correlated: neighbouring samples by {:.3f} +- {:.3f}, so it takes "
      "{:.2g} s to forget.",
      in_words(s.channel), ar.rho, ar.rho_sigma,
      ar.rho > 0.0 ? -1.0 / (std::log(ar.rho) * s.rate_hz) : 0.0);
  return test;
}

NoiseTest test_noise_scale(const NoiseSeries& s, const PieceSpectra& spectra, bool correlated,
                           double core_variance) {
  NoiseTest test;
  test.effect = "noise_scale";
  test.channel = s.channel;
  const auto fit = [&](const MeanSpectrum& mean) {
    return correlated ? fit_correlated(spectra, mean) : fit_white(spectra, mean);
  };
  const MeanSpectrum mean = mean_spectrum(spectra);
  const ColourFit whole = fit(mean);
  const double unit = spectra.unit.squaredNorm() / 3.0 * core_variance;
  const double variance_ratio = whole.v * unit / (s.sigma * s.sigma);
  const double scale = std::sqrt(variance_ratio);
  const double scatter = level_scatter(spectra);
  const double log_sigma =
      0.5 * (correlated ? whole.log_v_sigma : std::max(whole.log_v_sigma, scatter));
  const double off = std::log(scale);
  const double z = std::max({0.0, off - kDensityKnownTo, -off - kLessBy}) / log_sigma;
  test.statistic = z * z;
  test.p_value = std::min(1.0, 2.0 * normal_tail(z));
  const Halves in_time = halves(spectra, first_half);
  for (std::size_t i = 0; i < 2; ++i) {
    ColourFit other = fit(in_time[1 - i]);
    test.nll_after -= log_likelihood(spectra, in_time[i], other);
    other.v = s.sigma * s.sigma / unit;
    test.nll_before -= log_likelihood(spectra, in_time[i], other);
  }
  test.parameters = {{"s", scale, scale * log_sigma, ""}};
  test.sentence = fmt::format("The noise of the {} is {} times as large as given.",
                              in_words(s.channel), value_and_sigma(scale, scale * log_sigma));
  return test;
}

}  // namespace magimu
