// SPDX-License-Identifier: BSD-3-Clause
// All that a recording says of its device's parameters, in a few hundred numbers: the trajectory is
// eliminated at the optimum, and what is left is a quadratic in the parameters,
//
//   squares of all whitened residuals at their best = |R (x - at) + d|^2 + squares
//
// Recordings of one device add up in this form without their samples, in other processes and on
// other machines (archive/joint_estimate.h). Priors are not part of it: they count once a device.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "calibration/fit/optimum.h"

namespace magimu {

struct CondensedRecording {
  // Names and units as in Calibration::order; the dip of this recording is among them.
  std::vector<std::string> order;
  VectorXd at;  // where everything was linearized
  MatrixXd R;   // upper triangular; rows of what the motion does not tell are zero
  VectorXd d;
  double squares = 0.0;
  int rows = 0;         // residuals
  MatrixXd covariance;  // robust (uncertainty.h), of the optimum
  // moved: by how much each stretch of seconds moves the optimum, one column a stretch;
  // `covariance` is made of these (solvers/block_moves.h). beyond_noise: the covariance by which
  // both `covariance` and the triangle were widened.
  MatrixXd moved, beyond_noise;
  MatrixXd common;  // Calibration::covariance_common; empty: none
  bool common_in_triangle = true;
  // Of each parameter as the fit had it: mean and standard deviation; 0: none.
  VectorXd prior_mean, prior_sigma;
};

// optimum: fitted to one recording (or its parts). covariance, moved: as summarize()
// (fit/moved_by_blocks.h) gives them, parameters in the order of Calibration::order.
CondensedRecording condense_optimum(const Optimum& optimum, int magnetometers,
                                    const MatrixXd& covariance, const MatrixXd& moved);

// The parameters may lie elsewhere by what has this covariance, in order and units of
// CondensedRecording::order.
void widen(CondensedRecording& condensed, const MatrixXd& covariance);

// calibrate() of one recording, with that of its last fit; nothing where there was no fit.
Calibration calibrate_condensed(const Recording& recording, const CalibrationOptions& options,
                                std::optional<CondensedRecording>& condensed);

// The same of a recording whose motion does not tell all by itself, linearized where its device is
// known to be: the trajectory is fitted with the biases and distortions held there, so that what is
// left says which way they should move, and how sure that is. (By itself such a fit ends anywhere
// along what the motion leaves open.) The calibration's verdict is that of the device's parameters
// on this recording: no, too, where they differ beyond what both are uncertain by (p below 1 %).
// device: of as many magnetometers (else std::invalid_argument).
Calibration calibrate_condensed_at(const Calibration& device, const Recording& recording,
                                   const CalibrationOptions& options,
                                   std::optional<CondensedRecording>& condensed);

// Upper triangular R with R'R = information and d with R'd = -score, by eigenvalues of the
// information in scaled columns: below 1e-13 of the largest they are rounding, and left out.
void triangle_of(const MatrixXd& information, const VectorXd& score, MatrixXd& R, VectorXd& d);

}  // namespace magimu
