// SPDX-License-Identifier: BSD-3-Clause
// Noise densities from the residuals of a fit, by restricted maximum likelihood: a sensor's
// residuals are smaller than its noise because the trajectory has bent towards them, so their sum
// of squares is divided by the degrees of freedom that are left, rows - tr(J P J'), P the
// posterior covariance. The trace is estimated with seeded random signs (Hutchinson), to well below
// a per cent. Iterated with the fit until it settles.
//
// Each magnetometer of an array has a density of its own. One set of signs over the rows of all of
// them tells what each has absorbed, a_m: the products with the others' rows scatter about zero by
// sqrt(a_m / probes), and of an array each has few a_m and many rows.
#pragma once

#include "calibration/motion/sensor_rows.h"
#include "factors/sensor_model.h"
#include "solvers/linear/linear_solver.h"

namespace magimu {

// At a linearized optimum; solver must have been factorized there with this scale and no damping.
SensorSums residual_sums(const LinearSystem& system, const SensorRows& rows, LinearSolver& solver,
                         const VectorXd& scale);

// The densities under which the residuals would have unit variance. gyr_rested: rests tell the
// gyroscope's noise. Then what its few free rows have more is no noise but what the model lacks,
// and has to show: at least a fiftieth of the rows counts as free (SensorSums::rms).
NoiseDensities restricted_ml(const NoiseDensities& used, const SensorSums& sums,
                             bool gyr_rested = false);
// The same of each magnetometer of an array: of sums.magnetometers.
std::vector<double> restricted_ml(const std::vector<double>& used, const SensorSums& sums);

}  // namespace magimu
