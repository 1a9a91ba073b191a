// SPDX-License-Identifier: BSD-3-Clause
// Findings about the noise (noise_tests.h), by what the extended model leaves of single samples.
#pragma once

#include "diagnosis/noise/noise_tests.h"
#include "diagnosis/search/extender.h"

namespace magimu {

inline constexpr const char* kHardlyTurned = "the sensor hardly turned";  // why causes are not told

// Each recording is tested, and of each test the strongest result counts. turned: whether the
// sensor turned, without which ages of samples show in nothing.
void find_noise(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                const DiagnosisOptions& options, bool turned, Extender& extender, Diagnosis& d);

// If a finding says that the magnetometer has a clock of its own, and the model does not have that
// clock: subtracts the clock's errors from the residuals. level: of the test that finds it again.
void take_out_clock(const Diagnosis& d, const Stage& stage, double level,
                    std::vector<SampleResiduals>& residuals);

// Lines that are not the mains': of samples that are interpolated between measurements (only those
// of 50 and 60 Hz keep their name), and of a pattern of every second, third or fourth sample.
void withdraw_other_lines(const std::vector<const Recording*>& recordings, Diagnosis& d);

// Readings that pile up at the magnetometer's limit, found before anything is fitted: samples at
// the limit, and so near it that noise may have clipped them, are taken out of the recordings. Adds
// a finding if there are any.
void take_out_saturated(std::vector<Recording>& recordings, const DiagnosisOptions& options,
                        Diagnosis& d);

// Does it tell how large, how coloured or how heavy-tailed a sensor's noise is?
bool is_size_of_noise(const Finding& f);

}  // namespace magimu
