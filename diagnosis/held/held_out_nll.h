// SPDX-License-Identifier: BSD-3-Clause
// How well a model predicts data which its parameters have not seen: negative log-likelihood of
// each window of some seconds, -log p(y_W | other windows), the trajectory inside of W integrated
// out (Laplace), and so are the parameters of effects, with what the other windows say of them and
// their prior: one of them may hardly know what shows in W alone. The calibration is that which
// fits the others best. Both come from the condensed windows: one step from the joint optimum.
#pragma once

#include <vector>

#include "calibration/fit/stage.h"

namespace magimu {

// Per window, nats. stage: fitted. seconds: of a window, long enough that a window by itself shows
// most of what an effect does: much of it is carried on by the trajectory.
std::vector<double> held_out_nll(const Stage& stage, double seconds = 20.0);
double sum_of(const std::vector<double>& values);

}  // namespace magimu
