// SPDX-License-Identifier: BSD-3-Clause
// What is known beside the fit, and what a finding must not contradict: samples whose times a check
// has found bad are no wrong clock; a field that changes while the sensor rests is not one that the
// sensor passes; a magnetometer that seems ahead by half a gyroscope interval is a convention.
#pragma once

#include "diagnosis/result/diagnosis.h"

namespace magimu {

// Withdraws findings; says what others are that look like what they are named. given: the
// recordings as they were given.
void withdraw_contradicted(const std::vector<const Recording*>& given, Diagnosis& d);
void reword_by_what_is_known(const std::vector<const Recording*>& given, Diagnosis& d);

}  // namespace magimu
