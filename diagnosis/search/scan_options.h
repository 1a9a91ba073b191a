// SPDX-License-Identifier: BSD-3-Clause
// The candidates of one fitted model, tested without refitting, as options of its extension.
#pragma once

#include "diagnosis/search/option.h"

namespace magimu {

// Best first. effects: candidates as they are in the catalogue. A family gets the number of terms
// that is most significant, a change the times that explain most, a source a few likely places.
std::vector<Option> scan_options(const std::vector<const Recording*>& recordings,
                                 const Stage& stage,
                                 const std::vector<std::shared_ptr<const Effect>>& effects);

}  // namespace magimu
