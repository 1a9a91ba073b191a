// SPDX-License-Identifier: BSD-3-Clause
// Tables in "long format": every row is one sensor's, or one number's, and a column of words says
// which. Internal to recording/csv.
#pragma once

#include <vector>

#include "recording/csv/dialects/csv_dialect.h"
#include "recording/csv/dialects/head_lines.h"

namespace magimu {

// Whether a table is one, by a column of words that name sensors and columns of their numbers. Then
// it gives the dialect the names of the columns, a translator of rows, notes and, where the file
// holds all rows of one sensor before those of the next, each sensor's own times. `lines`: the
// first ones of the file; `elsewhere`: from the rest of it. The dialect's names are those of the
// header, or none.
bool long_format_dialect(const std::vector<HeadLine>& lines, const std::vector<HeadLine>& elsewhere,
                         const TableShape& shape, const CsvOptions& options, CsvDialect& dialect);

}  // namespace magimu
