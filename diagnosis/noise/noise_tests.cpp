// SPDX-License-Identifier: BSD-3-Clause
// All noise-like causes, alone and one after the other: noise_tests.h.
#include "diagnosis/noise/noise_tests.h"

#include <cmath>

#include "diagnosis/noise/high_pass.h"
#include "diagnosis/noise/noise_causes.h"

namespace magimu {
namespace {

// Rounding alone looks like coloured, scaled or heavy-tailed noise. By how much the data must
// exceed that: so many standard deviations and this share of the parameter; this much of the
// outliers' statistic.
constexpr double kBeyondSigmas = 4.0, kBeyondShare = 0.1, kBeyondStatistic = 20.0;
// Of the given scale: a core with outliers is not noise smaller than given.
constexpr double kAsGiven = 0.95;
constexpr double kRoundingDivisor = 12.0;  // step^2 over this is the variance of rounding

// Why the series cannot be tested at all; empty if it can.
std::string obstacle(const NoiseSeries& s) {
  if (s.size() < kLeastSamples || s.used_count() < kLeastSamples) return "too few samples";
  for (int axis = 0; axis < 3; ++axis) {
    bool varies = false;
    for (std::size_t k = 0; k < s.size() && !varies; ++k) varies = s.residual[k][axis] != 0.0;
    if (!varies) return "there is no noise";
  }
  return "";
}

std::vector<std::string> effects_of(const NoiseSeries& s) {
  std::vector<std::string> effects = {"noise_scale", "correlated_noise", "outliers"};
  if (s.channel == Sensor::kMag) {
    effects.insert(effects.end(), {"mag_quantization", "mag_saturation", "mains_interference"});
  }
  return effects;
}

NoiseTest test_scale_if_given(const NoiseSeries& s, const PieceSpectra& spectra,
                              bool correlated = false, double core_variance = 1.0) {
  if (!s.sigma_given || !(s.sigma > 0.0)) {
    return untested("noise_scale", s.channel, "no noise density is given to compare with");
  }
  return test_noise_scale(s, spectra, correlated, core_variance);
}

NoiseTest spectrum_test(const NoiseSeries& s, const PieceSpectra& spectra) {
  if (spectra.power.size() < 4) {
    return untested("correlated_noise", s.channel, "too few samples without gaps");
  }
  return test_correlated_noise(s, spectra);
}

// The samples that white noise and rounding alone would make of what the model predicts.
NoiseSeries imitation(const NoiseSeries& s, const Cleaned& c, double q) {
  const double seen = std::sqrt(c.scale.squaredNorm() / 3.0 / kHighPassVariance);
  const double white =
      s.sigma > 0.0 ? s.sigma : std::sqrt(std::max(seen * seen - q * q / kRoundingDivisor, 0.0));
  NoiseSeries copy = s;
  for (std::size_t k = 0; k < s.size(); ++k) copy.reading[k] = s.reading[k] - s.residual[k];
  const std::vector<Vector3> predicted = copy.reading;
  add_noise(copy.reading, std::max(white, 0.02 * q), {}, 1);
  quantize(copy.reading, q);
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.used[k]) copy.residual[k] = copy.reading[k] - predicted[k];
  }
  return copy;
}

// Beyond what rounding imitates: the leading parameter differs by more than both uncertainties.
bool beyond(const NoiseTest& seen, const NoiseTest& imitated, double least) {
  if (seen.parameters.empty()) return false;
  if (imitated.parameters.empty()) return true;
  const FoundParameter &a = seen.parameters[0], &b = imitated.parameters[0];
  return a.value - b.value > kBeyondSigmas * std::hypot(a.sigma, b.sigma) + least;
}

class Explanation {
 public:
  Explanation(const SampleResiduals& residuals, double level)
      : series_(make_noise_series(residuals)), level_(level) {}

  std::vector<NoiseTest> run() {
    if (!obstacle(series_).empty()) return {};
    cleaned_ = clean(series_);
    if (series_.channel == Sensor::kMag) converter_and_mains();
    if (series_.used_count() < kLeastSamples) return found_;
    shape_of_noise();
    return found_;
  }

 private:
  // A cause that predicts left-out samples worse than the model without it is none.
  bool accept(NoiseTest test) {
    if (!(test.p_value < level_) || test.nll_after > test.nll_before) return false;
    found_.push_back(std::move(test));
    return true;
  }

  void converter_and_mains() {
    if (accept(test_saturation(series_, cleaned_))) {
      drop_saturated(series_, found_.back().parameters[0].value);
      cleaned_ = clean(series_);
    }
    if (series_.used_count() < kLeastSamples) return;
    if (accept(test_quantization(series_, cleaned_))) step_ = found_.back().parameters[0].value;
    NoiseTest mains_test = test_mains(series_, cleaned_);
    if (step_ > 0.0) {
      // In a steady motion rounding makes lines of its own.
      const NoiseSeries rounded = imitation(series_, cleaned_, step_);
      const double whistle = test_mains(rounded, clean(rounded)).statistic;
      if (mains_test.statistic < 2.0 * whistle) mains_test.p_value = 1.0;
    }
    std::vector<Mains> lines = mains_test.of_motion;
    if (accept(mains_test)) lines.push_back(found_mains(found_.back()));
    // Lines of the motion are taken out, too: they are no noise.
    for (const Mains& line : lines) take_out(line);
    if (!lines.empty()) cleaned_ = clean(series_);
  }

  void take_out(const Mains& line) {
    for (std::size_t k = 0; k < series_.size(); ++k) {
      if (!series_.used[k]) continue;
      const Vector3 field = line.at(series_.t[k]);
      series_.residual[k] -= line.of_room ? Vector3(series_.to_n[k].inverse() * field) : field;
    }
  }

  void shape_of_noise() {
    OutlierShares shares;
    NoiseTest outliers = test_outliers(series_, cleaned_, &shares);
    const PieceSpectra spectra = piece_spectra(series_, cleaned_);
    NoiseTest correlated = spectrum_test(series_, spectra);
    NoiseSeries rounded;
    if (step_ > 0.0) {
      rounded = imitation(series_, cleaned_, step_);
      const Cleaned rounded_clean = clean(rounded);
      const NoiseTest imitated = spectrum_test(rounded, piece_spectra(rounded, rounded_clean));
      if (!beyond(correlated, imitated, kBeyondShare)) correlated.p_value = 1.0;
      const NoiseTest as_rounded = test_outliers(rounded, rounded_clean);
      if (outliers.statistic < 2.0 * as_rounded.statistic + kBeyondStatistic)
        outliers.p_value = 1.0;
    }
    const bool has_outliers = accept(outliers);
    const bool is_correlated = accept(correlated);
    if (is_correlated && has_outliers) resize_outliers(spectra, found_[found_.size() - 2]);
    if (spectra.power.size() < 4) return;
    if (!has_outliers) shares = {};
    NoiseTest scale = test_scale_if_given(series_, spectra, is_correlated, shares.core_of_cleaned);
    if (scale.parameters.empty()) return;
    const double s = scale.parameters[0].value;
    // Outliers are outside of the core's variance. A small core with the given variance in all is
    // no noise that is smaller than given.
    const double whole = s * std::sqrt(shares.all_of_cleaned / shares.core_of_cleaned);
    if (has_outliers && s < 1.0 && whole > kAsGiven) scale.p_value = 1.0;
    if (step_ > 0.0) {
      const NoiseTest imitated =
          test_scale_if_given(rounded, piece_spectra(rounded, clean(rounded)));
      const FoundParameter& other = imitated.parameters[0];
      if (s < 1.0 || !beyond(scale, imitated, kBeyondShare * other.value)) scale.p_value = 1.0;
    }
    accept(scale);
  }

  // K was found in units of the high-passed noise. That is smaller than the whole noise where
  // neighbours are correlated, and K counts in units of the whole.
  void resize_outliers(const PieceSpectra& spectra, NoiseTest& outliers) {
    const ColourFit fit = fit_correlated(spectra, mean_spectrum(spectra));
    outliers.parameters[1].value /= std::sqrt(fit.v);
    outliers.parameters[1].sigma /= std::sqrt(fit.v);
  }

  NoiseSeries series_;
  Cleaned cleaned_;
  double level_;
  double step_ = 0.0;
  std::vector<NoiseTest> found_;
};

std::vector<NoiseTest> test_channel(const SampleResiduals& residuals) {
  const NoiseSeries s = make_noise_series(residuals);
  std::vector<NoiseTest> tests;
  if (const std::string why = obstacle(s); !why.empty()) {
    for (const std::string& effect : effects_of(s))
      tests.push_back(untested(effect, s.channel, why));
    return tests;
  }
  const Cleaned cleaned = clean(s);
  const PieceSpectra spectra = piece_spectra(s, cleaned);
  tests.push_back(test_scale_if_given(s, spectra));
  tests.push_back(spectrum_test(s, spectra));
  tests.push_back(test_outliers(s, cleaned));
  if (s.channel != Sensor::kMag) return tests;
  tests.push_back(test_quantization(s, cleaned));
  tests.push_back(test_saturation(s, cleaned));
  tests.push_back(test_mains(s, cleaned));
  return tests;
}

}  // namespace

NoiseTest untested(const std::string& effect, Sensor channel, const std::string& why) {
  NoiseTest test;
  test.effect = effect;
  test.channel = channel;
  test.untested = why;
  return test;
}

std::vector<NoiseTest> test_noise(const std::vector<SampleResiduals>& channels) {
  std::vector<NoiseTest> tests;
  for (const SampleResiduals& channel : channels) {
    for (NoiseTest& test : test_channel(channel)) tests.push_back(std::move(test));
  }
  return tests;
}

std::vector<NoiseTest> explain_noise(const std::vector<SampleResiduals>& channels, double level) {
  std::vector<NoiseTest> found;
  for (const SampleResiduals& channel : channels) {
    for (NoiseTest& test : Explanation(channel, level).run()) found.push_back(std::move(test));
  }
  return found;
}

}  // namespace magimu
