// SPDX-License-Identifier: BSD-3-Clause
// A trajectory with its covariance as files: CSV and JSON (docs/formats.md).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "navigation/navigate.h"

namespace magimu {

// Covariance of position, velocity and attitude at one time, all in n: m, m/s, rad. The attitude's
// error is that of the library, R_true = Exp(delta) R.
Eigen::Matrix<double, 9, 9> covariance_in_n(const NavigationRun& run, std::size_t k);

std::string navigation_csv(const NavigationRun& run);
// The list of times; the command adds what it says besides.
nlohmann::ordered_json navigation_json(const NavigationRun& run);

}  // namespace magimu
