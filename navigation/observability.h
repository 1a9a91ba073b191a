// SPDX-License-Identifier: BSD-3-Clause
// The observability constraint of OC-MAINS. An array of magnetometers and an IMU cannot observe
// yaw: a turn of everything about the vertical axis changes no reading. In the error coordinates of
// navigation_state.h that turn (with the place kept) is the direction
//
//   (0; -[v]x g; R' g; 0; 0; 0 on theta).
//
// The exact derivatives map this direction onto itself from step to step. A filter's derivatives do
// not, because R and v in them change at every update, so it gains knowledge of yaw from nowhere.
// The constraint changes each step's derivatives as little as possible so that they do, with R and
// v as they were predicted.
#pragma once

#include "navigation/navigation_state.h"

namespace magimu {

// 15 + kappa numbers, of length about g.
VectorXd yaw_direction(const NavigationState& predicted, double gravity);

// Changes the derivatives `by_error` of a step from `updated` to `next` so that they map the
// direction of yaw at `predicted` (`updated` before its update) to that at `next`. Position is left
// out: its error is unobservable in every direction.
void constrain_yaw(NavigationStep& step, const NavigationState& predicted,
                   const NavigationState& updated, const Vector3& phi, double dt, double gravity);

}  // namespace magimu
