// SPDX-License-Identifier: BSD-3-Clause
// Findings about the noise (noise_tests.h), on what the extended model leaves of single samples.
#pragma once

#include "diagnosis/extender.h"

namespace magimu {

void find_noise(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                const DiagnosisOptions& options, Extender& extender, Diagnosis& d);

}  // namespace magimu
