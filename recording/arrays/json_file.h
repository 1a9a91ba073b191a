// SPDX-License-Identifier: BSD-3-Clause
// Recordings in JSON as programs export them whole: an array of objects, one a sample or one a
// sensor's reading ([{"t":0,"ax":1,...},...], Sensor Logger), or an object of arrays
// ({"t":[...],"acc":[[...],...]}). Lines of an object each are text like any other (csv_dialect.h).
#pragma once

#include <string>
#include <string_view>

#include "recording/csv/csv.h"

namespace magimu {

// head: the beginning of the file.
bool is_json_table(const std::string& path, std::string_view head);

Recording read_json(const std::string& path, const CsvOptions& options);

}  // namespace magimu
