// SPDX-License-Identifier: BSD-3-Clause
// A calibration's parameters as one vector, in the order and units of its covariance.
#pragma once

#include "calibration/result/calibration.h"

namespace magimu {

// acc_bias, gyr_bias, distortion (column by column) and bias of each magnetometer, the dips
// (degrees), then the parameters of its effects: Calibration::order has their names.
VectorXd parameter_vector(const Calibration& c);

// The other way round; strength and the first dip follow. The sigmas stay as they are.
void set_parameters(Calibration& c, const VectorXd& theta);

// The same numbers in variables of the graph, among the values of the calibration's fit.
Values as_globals(const Calibration& c, const std::vector<Key>& keys, const VectorXd& theta);

}  // namespace magimu
