// SPDX-License-Identifier: BSD-3-Clause
// Which effects can be told from these recordings at all: some need a column that the files lack,
// some are taken up by the hand's motion, some belong to one recording.
#pragma once

#include <string>
#include <vector>

#include "calibration/fit/stage.h"

namespace magimu {

// Why an effect cannot be tested on these recordings under this model; empty: it can.
std::string reason_untested(const Effect& effect, const std::vector<const Recording*>& recordings,
                            const Stage& stage);

// All of the catalogue that can be tested in one scan, the gyroscope's drift as a random walk of
// unit density. What needs a search of its own (for times, a place, a frequency, a clock) is not
// among them.
std::vector<std::shared_ptr<const Effect>> testable_effects(
    const std::vector<const Recording*>& recordings, const Stage& stage);

// How many of the catalogue are looked for in what a fit leaves: all but a coupling, which is in
// the noise of arrays.
int count_looked_for();

}  // namespace magimu
