// SPDX-License-Identifier: BSD-3-Clause
// How large a change of a device is, in the parameters' own units: the first question once
// something has changed.
//
// The change of a step, and that of a trend from the first recording to the last, are parameters
// beside the device's: their estimate is that of all recordings with the other changes in the
// model. Walks and scatter have no change but a standard deviation, which is where the evidence is
// largest, and as sure as the evidence is curved there.
#pragma once

#include <string>

#include "archive/change_search.h"

namespace magimu {

// kStep: what changed; kTrend: from the first recording to the last; kWalk: from one to the next,
// RMS; kScatter: about the mean, RMS. Lengths of vectors.
struct ChangeSize {
  double value = 0.0, sigma = 0.0;
  std::string unit;  // "uT", "rad/s", "m/s^2"; "%" of the whole, of distortions and factors
};

// scale: a coordinate's unit; joint: parameters that the coordinates are about; widened: what the
// recordings' standard deviations are multiplied by.
ChangeSize size_of_change(const ChangeProblem& problem, const ChangeHistory& history,
                          std::size_t which, const VectorXd& scale, const VectorXd& joint,
                          double widened);

}  // namespace magimu
