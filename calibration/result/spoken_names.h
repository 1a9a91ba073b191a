// SPDX-License-Identifier: BSD-3-Clause
// What users call the variables of a model.
#pragma once

#include <string>

#include "graph/key.h"

namespace magimu {

// "the distortion matrix", "the gyroscope bias", ...
std::string spoken_name(Key key);

}  // namespace magimu
