// SPDX-License-Identifier: BSD-3-Clause
// What is said of samples that were set aside, and how much of a sensor may be lost.
#pragma once

#include "recording/data/recording.h"

namespace magimu {

// So many samples of a sensor hardly count; with more of them missing a result deserves less trust.
inline constexpr double kSetAsideFew = 0.01;
// With more, what is left is not to be believed either.
inline constexpr double kSetAsideMost = 0.5;

// "acc: 1 of 12000 samples is set aside, an isolated jump: acc_x = 98000 m/s^2 at 36.00 s
// (neighbours read 1.2)", without a full stop; and what to do about it.
std::string sentence(const SetAside& what);
std::string remedy(const SetAside& what);

// Rows of zeros may be a logger's way to say that a slow sensor had no new sample, and what a
// stream left out of itself it can do without: these are no loss. All others are.
double lost_share(const SetAside& what);

}  // namespace magimu
