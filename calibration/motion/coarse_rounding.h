// SPDX-License-Identifier: BSD-3-Clause
// What rounding adds to the noise of an inertial sensor that is less noisy than its steps are wide
// (recording/checks/rounding.h): while a reading stays as it is, it is wrong by the same part of a
// step. As white noise that leads as far by the end of that time; the mean of the axes.
#pragma once

#include <vector>

#include "calibration/motion/block_means.h"
#include "recording/data/recording.h"

namespace magimu {

// Adds to the variances of one axis (bridged_gaps.h) what rounding adds to the integral of the
// readings between each two of these times. Leaves them alone where noise takes care of the
// rounding.
void add_rounding(const VectorSeries& series, const std::vector<double>& times,
                  std::vector<double>& variances);

// Variances of one axis that it adds to these means of the readings; empty where noise takes care
// of it.
std::vector<double> rounding_of_means(const VectorSeries& series,
                                      const std::vector<NodeMean>& means);

}  // namespace magimu
