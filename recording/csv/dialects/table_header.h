// SPDX-License-Identifier: BSD-3-Clause
// The names of a table's columns: one line above the rows or two, with units or the sensors' names
// in one of them. Internal to recording/csv.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/csv/columns/csv_options.h"
#include "recording/csv/dialects/head_lines.h"

namespace magimu {

struct TableHeader {
  std::vector<std::string> names;  // of the columns, as many as the rows have fields
  std::size_t line = 0;            // index of the header's first line
  std::size_t rows = 0;            // lines from there to the first row of numbers
  std::size_t levels = 0;          // of them, with names that belong together (pandas)
};

// The header that names most of the quantities known here; empty if no line above the rows is one.
std::optional<TableHeader> table_header(const std::vector<HeadLine>& lines, const TableShape& shape,
                                        const CsvOptions& options);

}  // namespace magimu
