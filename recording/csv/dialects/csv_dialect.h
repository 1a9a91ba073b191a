// SPDX-License-Identifier: BSD-3-Clause
// What kind of text a file is, recognised from its first lines: separator, decimal comma, lines
// above the header, where the header is (none, behind '#', in two rows, with units below it), or
// something else than a table (labelled numbers, a sensor a row). One answer for all of it: the
// names of the columns, the first row, and what makes rows of the lines.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/columns/csv_options.h"
#include "recording/csv/dialects/line_translator.h"

namespace magimu {

struct CsvDialect {
  // Names of the columns, one a field. Empty: the file is plain, and its first line its header.
  std::vector<std::string> names;
  long header_line = 0;  // 0: it has none
  std::string header;    // the text of that line: it may come again within the rows
  long first_row = 1;    // lines before it hold no samples
  char separator = ',';
  std::shared_ptr<LineTranslator> translator;  // null: lines are rows as they are
  // Sensor -> its own column of times. Empty: one time column serves all.
  std::map<std::string, std::string> times_of;
  bool one_sensor_a_line = false;
  bool marked_rows = false;  // rows begin with '#', as comments do elsewhere
  std::vector<std::string> notes;

  bool plain() const { return names.empty(); }
};

// `head`: the first lines of the file, all of them whole (the last one may be cut off if the file
// ends there). `elsewhere`: whole lines from the rest of the file, if they are known. Throws
// InputError if there is no header and options give none.
CsvDialect recognised_dialect(std::string_view head, const std::string& file,
                              const CsvOptions& options, std::string_view elsewhere = {});

}  // namespace magimu
