// SPDX-License-Identifier: BSD-3-Clause
// The uncertainty of a finished fit: covariance of the parameters under the model and robust
// (sandwich), and the combinations that the data leave undetermined, named.
#pragma once

#include "calibration/fit/optimum.h"
#include "calibration/result/calibration.h"
#include "calibration/result/calibration_options.h"
#include "solvers/marginals.h"

namespace magimu {

// Fills order, covariance, covariance_model, undetermined, and the sigmas of field and strength.
// at: where c was filled from; marginals: there.
void fill_uncertainty(Calibration& c, const Optimum& at, const Marginals& marginals,
                      double block_s);

// Independent pieces of block_s behind the robust covariance.
int covariance_blocks(const Calibration& c, double block_s);

// Of these covariance, covariance_model and the sigmas, from covariances in the parameters' own
// units (dips in rad). c.order is filled already.
void fill_covariance(Calibration& c, const MatrixXd& robust, const MatrixXd& model);

// Standard deviation of the strength of the field, uT: that of the cube root of det D, with the
// covariance in the order and units of Calibration::order.
double strength_sigma(const Matrix3& D, double strength, const MatrixXd& covariance);

// Multiplies the reported standard deviations by that factor; those of the model do not change.
void widen_uncertainty(Calibration& c, double factor);
// Adds to the reported covariance, in the order and units of Calibration::order; not the model's.
void add_to_covariance(Calibration& c, const MatrixXd& more);
// Standard deviations of fields, effects and strength from the two covariances.
void take_over_sigmas(Calibration& c);

}  // namespace magimu
