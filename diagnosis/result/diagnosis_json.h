// SPDX-License-Identifier: BSD-3-Clause
// A diagnosis as a file of the format "magimu-diagnosis/1" (docs/formats.md lists its fields). What
// is not a number is null there. The residuals' traces are for pictures and are left out.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/result/diagnosis.h"

namespace magimu {

nlohmann::ordered_json to_json(const Diagnosis& diagnosis);

}  // namespace magimu
