// SPDX-License-Identifier: BSD-3-Clause
// The scan's numbers in the words and figures of a finding.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/search/option.h"

namespace magimu {

// The size, in standard deviations, that is found nine times out of ten: the root of the statistic
// at which the tail of the chi-square distribution reaches the level, and 1.28 more.
double detectable_size(int dof, double log10_level);

std::string walk_sentence(const FoundParameter& density);

// Candidates that explain much of the same misfit with this motion.
std::vector<Confusable> confusable(const Option& option, const std::vector<Option>& all);

// The scan as reported: what was tested, and what could not be, with the reason.
std::vector<ScanEntry> scan_entries(const std::vector<Option>& options,
                                    const std::vector<const Recording*>& recordings,
                                    const Stage& stage, double log10_level);

}  // namespace magimu
