// SPDX-License-Identifier: BSD-3-Clause
// How well a model predicts data which its parameters have not seen: negative log-likelihood of
// each window of some seconds, -log p(y_W | other windows). The trajectory inside of W is
// integrated out (Laplace). So are the parameters of effects, under their prior and the other
// windows' information: a parameter that shows in W alone is hardly known without W. The
// calibration is the one that fits the other windows best. All of it comes from the condensed
// windows, by one step from the joint optimum.
#pragma once

#include <vector>

#include "calibration/fit/stage.h"

namespace magimu {

// Per window, nats. stage: fitted. seconds: length of a window. It must be long enough to show most
// of an effect by itself, since the trajectory carries on what a shorter one would show.
std::vector<double> held_out_nll(const Stage& stage, double seconds = 20.0);
double sum_of(const std::vector<double>& values);

}  // namespace magimu
