// SPDX-License-Identifier: BSD-3-Clause
// What a user can do about what is not explained: it follows from where that is.
#pragma once

#include <string>

#include "diagnosis/result/diagnosis.h"

namespace magimu {

// d: with its answer and what is unexplained. Empty where there is nothing to do.
std::string next_step(const Diagnosis& d);

// Do the standard deviations know of what is not explained? A sentence.
std::string what_sigmas_know(const Diagnosis& d);

}  // namespace magimu
