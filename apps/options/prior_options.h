// SPDX-License-Identifier: BSD-3-Clause
// What is known of the device beforehand: --prior, --prior-age, --prior-drift.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "apps/options/reading_options.h"
#include "calibration/calibrate.h"

namespace magimu::apps {

struct PriorArguments {
  std::string prior = "default";
  double age_days = -1.0;  // negative: computed from the date in the file
  double drift = 1.0;
  bool has_age = false, has_drift = false;

  // Reads the calibration that is named into `Options` (of a calibration or a stream). Throws
  // InputError, also if the recording is read in other axes.
  template <class Options>
  void apply_to(Options& options, const ReadingOptions& reading) const {
    const CalibrationOptions known = read(reading);
    options.prior = known.prior;
    options.given_prior = known.given_prior;
  }

 private:
  CalibrationOptions read(const ReadingOptions& reading) const;
};

// Adds the options. `arguments` must outlive `cmd`.
void add_prior_options(CLI::App& cmd, PriorArguments& arguments);

}  // namespace magimu::apps
