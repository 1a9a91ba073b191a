// SPDX-License-Identifier: BSD-3-Clause
// Findings about the noise (noise_tests.h), on what the extended model leaves of single samples.
#pragma once

#include <optional>

#include "diagnosis/extender.h"

namespace magimu {

void find_noise(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                const DiagnosisOptions& options, Extender& extender, Diagnosis& d);

// Readings that pile up at the magnetometer's limit, found before anything is fitted: the samples
// at the limit are taken out of the recording. The finding, if there are such.
std::optional<Finding> take_out_saturated(Recording& recording, const DiagnosisOptions& options);

}  // namespace magimu
