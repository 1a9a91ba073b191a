// SPDX-License-Identifier: BSD-3-Clause
// A magnet that the sensor passes, where no positions were recorded to find its place: the
// magnetometer departs from the model for some seconds, comes back, and departs again elsewhere,
// tied to neither orientation nor a lasting change.
#pragma once

#include <optional>
#include <string>

#include "diagnosis/search/extender.h"

namespace magimu {

struct PassingSource {
  std::optional<Finding> finding;
  // A sentence where the departures only turn the field (an error of the attitude or of time) or
  // lie along one line of the sensor's own frame (the device makes them); else empty.
  std::string evidence = {};
  Sensor channel = Sensor::kMag;  // of the evidence
};
// On what the extended model leaves. Nothing where positions are known (the scan looks for the
// place then) or where the departures are the rule rather than the exception.
PassingSource find_passing_source(const std::vector<const Recording*>& recordings,
                                  const Stage& stage);

}  // namespace magimu
