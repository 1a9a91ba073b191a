// SPDX-License-Identifier: BSD-3-Clause
// Recordings whose gyroscope samples are rates that lead from attitude to attitude, as every fit
// takes them. The mean of a rate over a sampling interval does not, where the axis turns meanwhile
// (coning.h). Where the difference shows, both kinds of samples are fitted, and the one under which
// the readings are more probable is taken.
#pragma once

#include <deque>
#include <string>

#include "calibration/calibrate.h"

namespace magimu {

class TurningRates {
 public:
  // The recordings must outlive this: where the two kinds do not differ, get() returns them.
  TurningRates(const std::vector<const Recording*>& all, const CalibrationOptions& options);
  TurningRates(const TurningRates&) = delete;
  TurningRates& operator=(const TurningRates&) = delete;

  const std::vector<const Recording*>& get() const { return recordings_; }
  // What was done; empty: nothing.
  const std::string& said() const { return said_; }

 private:
  std::deque<Recording> copies_;
  std::vector<const Recording*> recordings_;
  std::string said_;
};

}  // namespace magimu
