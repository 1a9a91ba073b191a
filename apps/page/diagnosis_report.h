// SPDX-License-Identifier: BSD-3-Clause
// A diagnosis as a page to show to others: the answer, what was found, what is left, what could not
// have been seen, and how it was tested.
#pragma once

#include <string>

#include "diagnosis/result/diagnosis.h"

namespace magimu::apps {

std::string diagnosis_report(const Diagnosis& diagnosis);

}  // namespace magimu::apps
