// SPDX-License-Identifier: BSD-3-Clause
// The scan as a picture: every candidate by the strength of its evidence.
#pragma once

#include <string>

#include "diagnosis/result/diagnosis.h"

namespace magimu::apps {

// -log10 of the chance that noise alone would look so much like this cause; from the statistic
// where the p-value is too small for a double.
double evidence(const ScanEntry& entry);
// The evidence that a cause needs, as so many are tested.
double evidence_needed(const Diagnosis& diagnosis);

std::string scan_chart(const Diagnosis& diagnosis);

}  // namespace magimu::apps
