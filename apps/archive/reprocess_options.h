// SPDX-License-Identifier: BSD-3-Clause
// The options of one recording in an archive: those of `magimu calibrate` that change its result,
// for all recordings (--options) and in a manifest's column.
#pragma once

#include <string>
#include <vector>

#include "apps/options/common_options.h"
#include "apps/options/place_options.h"
#include "calibration/calibrate.h"

namespace magimu::apps {

struct ReprocessRowOptions : RecordingOptions {
  PlaceOptions place_of_field;
  std::string mag_time_offset = "auto", gyro_matrix = "auto";
  int node_every = 0;

  CalibrationOptions calibration() const;
};

// InputError where a word is not understood.
ReprocessRowOptions parse_row_options(const std::vector<std::string>& words);

}  // namespace magimu::apps
