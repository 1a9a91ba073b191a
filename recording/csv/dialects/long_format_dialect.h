// SPDX-License-Identifier: BSD-3-Clause
// Tables in "long format": every row is one sensor's, or one number's, and a column of words says
// which. Internal to recording/csv.
#pragma once

#include <vector>

#include "recording/csv/dialects/csv_dialect.h"
#include "recording/csv/dialects/head_lines.h"

namespace magimu {

// True if a column of words names sensors and other columns hold their numbers. Then the dialect
// gets the columns' names, a translator of rows, and notes; and each sensor's own times where the
// file holds all rows of one sensor before those of the next. lines: the first ones of the file;
// elsewhere: some from the rest of it. The dialect comes with the header's names, or none.
bool long_format_dialect(const std::vector<HeadLine>& lines, const std::vector<HeadLine>& elsewhere,
                         const TableShape& shape, const CsvOptions& options, CsvDialect& dialect);

}  // namespace magimu
