// SPDX-License-Identifier: BSD-3-Clause
// Recordings whose gyroscope samples are rates that lead from attitude to attitude, as every fit
// takes them. Where a sensor is read slowly for how briskly it is turned, means of the rate are
// not (coning.h); which of the two its samples are the readings themselves tell, by which they are
// more probable.
#pragma once

#include <deque>
#include <string>

#include "calibration/calibrate.h"

namespace magimu {

class TurningRates {
 public:
  // Where it does not matter recordings are these themselves. They must outlive this.
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
