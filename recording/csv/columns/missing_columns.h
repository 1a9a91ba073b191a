// SPDX-License-Identifier: BSD-3-Clause
// What a header lacks, in words, with the line of options that maps the columns it has. Internal to
// csv_columns.cpp.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recording/csv/columns/csv_options.h"

namespace magimu {

// The columns of a header, and what is known of them.
struct HeaderColumns {
  std::vector<std::string> headers;                 // as in the file
  std::vector<bool> named;                          // whether a header is one of our quantities
  const std::map<std::string, std::size_t>& where;  // our name -> column

  // Whether there is an axis of it.
  bool has(const std::string& sensor) const;
  // All headers, the first 40 of them, for messages.
  std::string shown() const;
};

struct MissingColumns {
  bool time;  // is missing; else only sensors are
  std::string problem, remedy;
};

// All that is missing at once; empty where nothing is.
std::optional<MissingColumns> missing_columns(const HeaderColumns& columns,
                                              const CsvOptions& options);

}  // namespace magimu
