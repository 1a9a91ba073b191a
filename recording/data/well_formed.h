// SPDX-License-Identifier: BSD-3-Clause
// Is it a recording at all? Readers see to that; who fills a Recording by hand may not: a value for
// each time, times that are numbers, a name for each magnetometer. Every public function that takes
// recordings asks first, so that all behind it may rely on it. Whether the samples are what they
// seem to be is another question: recording/checks/quality.h.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

// Throws InputError with what is wrong. Magnetometers without any name at all may stand.
void require_well_formed(const Recording& recording);

// "mag", or "mag1", "mag2", ...: the names that readers give to magnetometers.
std::vector<std::string> usual_mag_names(std::size_t magnetometers);

// Recordings that are, their magnetometers with the usual names where they had none. They must
// outlive this.
class WellFormed {
 public:
  // Throws InputError.
  explicit WellFormed(const std::vector<const Recording*>& given);
  WellFormed(const WellFormed&) = delete;
  WellFormed& operator=(const WellFormed&) = delete;
  const std::vector<const Recording*>& get() const { return recordings_; }

 private:
  std::deque<Recording> named_;
  std::vector<const Recording*> recordings_;
};

}  // namespace magimu
