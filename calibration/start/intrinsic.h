// SPDX-License-Identifier: BSD-3-Clause
// Intrinsic calibration of a magnetometer from its own samples (Huang et al. 2025, eq. (intrinsic
// calibration)): the readings lie on an ellipsoid, m = D_I u + o_m with u on the unit sphere. First
// an algebraic fit, constrained to ellipsoids (Li and Griffiths 2004), then maximum likelihood with
// one direction u a sample. A direction is two coordinates about its own starting point, where roll
// and pitch angles would be singular at 90 degrees.
#pragma once

#include <vector>

#include "factors/sensor_model.h"

namespace magimu {

struct IntrinsicCalibration {
  Matrix3 distortion = Matrix3::Identity();  // D_I, lower triangular with positive diagonal, uT
  Vector3 bias = Vector3::Zero();            // o_m, uT
  double residual_rms_uT = 0.0;              // distance of the readings from the ellipsoid
  bool converged = false;
};

// The ellipsoid in closed form; needs at least nine readings that are not all in a plane. Falls
// back to a sphere where they do not carry an ellipsoid.
IntrinsicCalibration fit_ellipsoid(const std::vector<Vector3>& mag_uT);

// The ellipsoid, refined by maximum likelihood on at most max_samples readings. Readings of a
// sensor that did not turn: a sphere about 0 through their mean.
IntrinsicCalibration calibrate_intrinsic(const std::vector<Vector3>& mag_uT,
                                         int max_samples = 1500);

// How far the readings are from one ellipsoid when the field that they should show departs by
// misfit_uT (RMS): a field that changes does so along itself as much as across, which readings on
// one ellipsoid do not. True: what departs is a direction, and no magnet or iron.
bool only_directions_depart(double off_ellipsoid_uT, double misfit_uT);

}  // namespace magimu
