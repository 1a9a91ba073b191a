// SPDX-License-Identifier: BSD-3-Clause
// Lines that boards print for Teleplot (github.com/nesnes/teleplot), a number each:
//
//   >acc_x:0.25                      without time: --rate
//   >acc_x:1627551892437:0.25        ms
//   >acc_x:0.25\xC2\xA7m/s^2|g          with unit and flags
//
// A row is there as soon as the three axes of a sensor are. Internal to csv_dialect.cpp.
#pragma once

#include <optional>

#include "recording/csv/dialects/csv_dialect.h"
#include "recording/csv/dialects/head_lines.h"

namespace magimu {

// Nothing if the lines are something else.
std::optional<CsvDialect> teleplot_dialect(const std::vector<HeadLine>& lines,
                                           const CsvOptions& options);

}  // namespace magimu
