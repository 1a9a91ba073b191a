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
  double age_days = -1.0;  // negative: by the date of the file
  double drift = 1.0;
  bool has_age = false, has_drift = false;

  // Reads the calibration that is named. Throws InputError, also where the recording is not read in
  // its axes. Options: of a calibration or a stream.
  template <class Options>
  void apply_to(Options& options, const ReadingOptions& reading) const {
    const CalibrationOptions known = read(reading);
    options.prior = known.prior;
    options.given_prior = known.given_prior;
  }

 private:
  CalibrationOptions read(const ReadingOptions& reading) const;
};

// arguments must live as long as cmd.
void add_prior_options(CLI::App& cmd, PriorArguments& arguments);

}  // namespace magimu::apps
