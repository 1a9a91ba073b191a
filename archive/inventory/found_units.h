// SPDX-License-Identifier: BSD-3-Clause
// Units that a file gets wrong or does not tell, where the samples tell them: gravity's size, the
// turning that the magnetometer sees, the Earth's field. A person is asked to give them (--unit);
// in an archive nobody sits there, so that they are put right, and said.
#pragma once

#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

// Rescales sensors whose unit check_units() is sure of and names; returns what was done, as the
// options that a person would give ("--unit gyr=deg/s").
std::vector<std::string> put_units_right(Recording& recording);

}  // namespace magimu
