// SPDX-License-Identifier: BSD-3-Clause
// May this calibration be believed? The verdict, with reasons in words: did the fit converge, is
// everything determined, is the motion one that the model can carry, do the residuals look like
// noise, does the field stay the same.
#pragma once

#include <string>
#include <vector>

#include "calibration/result/calibration.h"
#include "calibration/result/calibration_options.h"
#include "recording/checks/quality.h"

namespace magimu {

// What is known of a misfit of the magnetometer beside the fit.
struct KnownOfMisfit {
  std::string cause;  // cause_of_misfit()
  std::string step;   // of the magnetometer's bias, in a sentence; empty: none is known
  // How far the first magnetometer's readings are from one ellipsoid, RMS, and its noise at rest,
  // one reading; 0: not known.
  double off_ellipsoid_uT = 0.0, at_rest_uT = 0.0;
  // One of the file's numbers of the gyroscope, rad/s, as it was read; 0: not known.
  double gyr_unit = 0.0;
};

// unknown: unknown_directions() of the fit itself, whose verdict is `no`.
void judge(Calibration& c, const std::vector<std::string>& unknown = {},
           const KnownOfMisfit& known = {});

// Of a residual of so much of the field's strength: what a verdict is lowered to.
Verdict verdict_on_misfit(double share);
// deg, of the corrected direction and of the dip: a board with a hard iron of 10 uT in a field of
// 50 uT is wrong by as much as it comes, so that such a calibration is worth nothing.
inline constexpr double kUselessDirection_deg = 10.0;
// Sentences where direction or dip are hardly known: asked before sigmas are widened for what may
// be missing in the model.
std::vector<std::string> unknown_directions(const Calibration& c);

// What ruins a calibration makes it `no`. Where the verdict is not `yes`, what the checks of the
// samples know is the first reason: everything else may follow from it. faults: the gravest first.
void judge_faults(Trust& trust, const std::vector<KnownFault>& faults);

}  // namespace magimu
