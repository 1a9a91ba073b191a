// SPDX-License-Identifier: BSD-3-Clause
// Findings about the noise (noise_tests.h), on what the extended model leaves of single samples.
#pragma once

#include "diagnosis/noise/noise_tests.h"
#include "diagnosis/search/extender.h"

namespace magimu {

// In each recording, of which the strongest counts.
void find_noise(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                const DiagnosisOptions& options, Extender& extender, Diagnosis& d);

// Where a clock of its own was found that the model has not: what it leaves of a magnetometer's
// samples is taken out of them. level: of the test that finds it again.
void take_out_clock(const Diagnosis& d, const Stage& stage, double level,
                    std::vector<SampleResiduals>& residuals);

// Lines that are not the mains': of samples that are interpolated between measurements (only those
// of 50 and 60 Hz keep their name), and of a pattern of every second, third or fourth sample.
void withdraw_other_lines(const std::vector<const Recording*>& recordings, Diagnosis& d);

// Readings that pile up at the magnetometer's limit, found before anything is fitted: the samples
// at the limit are taken out of the recordings. A finding, if there are such.
void take_out_saturated(std::vector<Recording>& recordings, const DiagnosisOptions& options,
                        Diagnosis& d);

// Does it tell how large, how coloured or how heavy-tailed a sensor's noise is?
bool is_size_of_noise(const Finding& f);

}  // namespace magimu
