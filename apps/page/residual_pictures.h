// SPDX-License-Identifier: BSD-3-Clause
// Pictures of a channel's residuals before and after the model was extended: the three axes over
// time, their correlation, their spectrum.
#pragma once

#include <string>

#include "diagnosis/result/diagnosis.h"

namespace magimu::apps {

struct ResidualPictures {
  std::string traces, correlation, spectrum;  // SVG
};

// `extended`: the model was extended, so there is an "after".
ResidualPictures residual_pictures(const ResidualTrace& trace, bool extended);

}  // namespace magimu::apps
