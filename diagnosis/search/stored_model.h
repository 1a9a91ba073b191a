// SPDX-License-Identifier: BSD-3-Clause
// The model of a stored calibration, fitted to new recordings: where a diagnosis may start instead
// of the model with 19 parameters.
#pragma once

#include <string>
#include <vector>

#include "calibration/pipeline.h"

namespace magimu {

// Motion and effects as stored, all parameters estimated anew, started from the stored ones.
// Effects that belong to a recording rather than to the device are left out, which goes into notes.
Stage stored_model(const Calibration& stored, const std::vector<const Recording*>& recordings,
                   const Pipeline& pipeline, std::vector<std::string>& notes);

}  // namespace magimu
