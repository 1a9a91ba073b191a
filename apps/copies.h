// SPDX-License-Identifier: BSD-3-Clause
// Recordings that are given twice. A copy is no second recording: it would halve the variances, and
// the noise that both share would look like a cause.
#pragma once

#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu::apps {

struct GivenCopy {
  std::string path, of;
};

// Takes out of paths what has the same bytes as one before.
std::vector<GivenCopy> leave_out_copies(std::vector<std::string>& paths);
// Says so among the cautions of the recordings that stay, which every result repeats.
void caution_of_copies(const std::vector<GivenCopy>& copies, std::vector<Recording>& recordings);

}  // namespace magimu::apps
