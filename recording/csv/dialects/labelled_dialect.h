// SPDX-License-Identifier: BSD-3-Clause
// Lines of labelled numbers, as boards print them: "ax:0.4,ay:1.05", "Accel X: 0.1 Y: 0.2 m/s^2",
// {"acc":[1,2,3]}, and the lines that MotionCal listens to:
//
//   Raw:ax,ay,az,gx,gy,gz,mx,my,mz   integers: 8192 a g, 16 a deg/s, 10 a uT
//   Uni:ax,ay,az,gx,gy,gz,mx,my,mz   m/s^2, rad/s, uT
//
// Internal to csv_dialect.cpp.
#pragma once

#include <optional>

#include "recording/csv/dialects/csv_dialect.h"
#include "recording/csv/dialects/head_lines.h"

namespace magimu {

// Nothing if the lines are something else.
std::optional<CsvDialect> labelled_dialect(const std::vector<HeadLine>& lines,
                                           const CsvOptions& options);

}  // namespace magimu
