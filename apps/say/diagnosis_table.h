// SPDX-License-Identifier: BSD-3-Clause
// A diagnosis as the terminal shows it: where a stored calibration was given, whether that still
// holds; the answer, then what could not be tested, what was looked for and not found, and what it
// does to the calibration.
#pragma once

#include <string>

#include "diagnosis/result/diagnosis.h"

namespace magimu::apps {

std::string diagnosis_table(const Diagnosis& diagnosis);

}  // namespace magimu::apps
