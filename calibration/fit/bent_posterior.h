// SPDX-License-Identifier: BSD-3-Clause
// How far the posterior bends away from its tangent ellipsoid. Along a direction that a short or
// poor motion hardly tells, distortion, bias and dip go together on a curve,
//
//   theta(s) = theta_0 + s a + s^2 / 2 b,      s ~ N(0, 1) along the direction,
//
// while a covariance knows the tangent a only: across it the ellipsoid is too thin. The curve's
// points at s = +-2 are found by one Newton step of the efficient score across the direction, the
// trajectory fitted anew; their second difference is b. About theta_0 the covariance of theta(s)
// is a a' + 3/4 b b', as E[s^4] = 3.
#pragma once

#include <optional>

#include "calibration/fit/stage.h"
#include "calibration/result/calibration.h"

namespace magimu {

struct BentPosterior {
  MatrixXd more;      // to be added to the covariance, order and units of Calibration::order
  double away = 0.0;  // sigmas of the ellipsoid by which the curve has left it at s = 1
};

// stage: fitted, with few nodes, of the same model as c. Nothing where no direction is known so
// badly that a bend could be seen (nearly always, and then it costs nothing).
std::optional<BentPosterior> bent_posterior(const Calibration& c, const Stage& stage);

// Widens the robust covariance of a calibration by the bend, and adds the check "curvature".
void add_bend(Calibration& c, const BentPosterior& bend);

}  // namespace magimu
