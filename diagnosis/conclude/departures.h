// SPDX-License-Identifier: BSD-3-Clause
// Where measurement and simulation part: statistics of a model's residuals against those of data
// simulated from the fitted model and fitted again. Bands are simultaneous: all statistics of one
// diagnosis together leave them where nothing is wrong in 0.3 % of recordings. Those of the basic
// model show where to look; any of the final model is evidence against it (conclude.h).
#pragma once

#include "diagnosis/search/extender.h"

namespace magimu {

inline constexpr double kSimultaneous = 0.003;

// The two-sided probability with which one of so many statistics may leave its band.
double level_of_one(int statistics);

// Fills d.departures, d.departures_after, d.statistics and d.traces. others: tests made elsewhere
// that share the level.
// full: the recordings with all their samples.
void fill_departures(const std::vector<const Recording*>& recordings,
                     const std::vector<const Recording*>& full, const Extender& extender,
                     const NoiseDensities& rest_noise, bool noise_given, int others, Diagnosis& d);

}  // namespace magimu
