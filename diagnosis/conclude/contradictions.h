// SPDX-License-Identifier: BSD-3-Clause
// A finding must not contradict what is known beside the fit. Times that a check has found bad are
// no wrong clock; what changes while the sensor rests was not passed by the sensor; a magnetometer
// that seems ahead by half a gyroscope interval is a convention of the gyroscope's times.
#pragma once

#include "diagnosis/result/diagnosis.h"

namespace magimu {

// given: the recordings as they were given. Takes out findings that are contradicted.
void withdraw_contradicted(const std::vector<const Recording*>& given, Diagnosis& d);
// A gyroscope's dead band is named, and what it imitates is not: what it reads of slow turns is
// wrong.
void name_dead_band(const std::vector<const Recording*>& given, Diagnosis& d);
// Gives findings that are conventions, or changes at rest, a sentence that says so.
void reword_by_what_is_known(const std::vector<const Recording*>& given, Diagnosis& d);

}  // namespace magimu
