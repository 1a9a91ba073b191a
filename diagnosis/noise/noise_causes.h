// SPDX-License-Identifier: BSD-3-Clause
// The single tests behind noise_tests.h, each of a series on which the causes found earlier have
// been taken into account.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/noise/noise_series.h"
#include "diagnosis/noise/noise_spectrum.h"
#include "factors/effects/noise_effects.h"

namespace magimu {

inline constexpr std::size_t kLeastSamples = 300;
inline constexpr double kDensityKnownTo = 0.005;  // relative: as well as a density can be given

// A test that was not made.
NoiseTest untested(const std::string& effect, Sensor channel, const std::string& why);

// Sizes of jumps are a mixture of two Gaussian scales: of high-passed samples, so that neither
// slow errors nor colour make outliers. (outliers.cpp)
// shares: variances by the mixture, over that of the cleaned series, which still has the smaller
// outliers.
struct OutlierShares {
  double core_of_cleaned = 1.0;  // variance without any outliers, in parts of the cleaned one's
  double all_of_cleaned = 1.0;   // variance with all of them
};
NoiseTest test_outliers(const NoiseSeries& series, const Cleaned& cleaned,
                        OutlierShares* shares = nullptr);

// AR(1) against white noise, both with something slow beside it. (noise_colour.cpp)
NoiseTest test_correlated_noise(const NoiseSeries& series, const PieceSpectra& spectra);

// Variance against the given one, of white noise or, where `correlated`, of AR(1) noise.
// core_variance: the part that is left of the cleaned series' variance when outliers too small to
// be set aside are left out. (noise_colour.cpp)
NoiseTest test_noise_scale(const NoiseSeries& series, const PieceSpectra& spectra,
                           bool correlated = false, double core_variance = 1.0);

// A line in the spectrum: the largest of all frequencies above 5 Hz (above a tenth of a rate below
// 50 Hz), each against its neighbourhood, in the sensor's frame or in n. (mains.cpp)
NoiseTest test_mains(const NoiseSeries& series, const Cleaned& cleaned);
Mains found_mains(const NoiseTest& test);
bool is_of_room(const std::vector<FoundParameter>& mains);
// Do mains of 50 or 60 Hz appear at this frequency, sampled at this rate?
bool is_mains(double f_hz, double rate_hz);

// Steps of the converter, and readings that pile up at +-M. (converter.cpp)
NoiseTest test_quantization(const NoiseSeries& series, const Cleaned& cleaned);
NoiseTest test_saturation(const NoiseSeries& series, const Cleaned& cleaned);
// Takes the samples out that have an axis at the limit.
void drop_saturated(NoiseSeries& series, double most);

}  // namespace magimu
