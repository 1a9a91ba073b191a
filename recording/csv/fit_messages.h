// SPDX-License-Identifier: BSD-3-Clause
// What Garmin's FitCSVTool makes of a FIT file: a message a row, each field as three cells (name,
// value, unit), and of the sensors as many samples a message as it holds, with bars between them
// ("0|40|80"). The messages and fields are those of Garmin's published profile.
#pragma once

#include <string>
#include <string_view>

#include "recording/csv/csv.h"

namespace magimu {

// head: the beginning of the file.
bool is_fit_messages(std::string_view head);

Recording read_fit_messages(const std::string& path, const CsvOptions& options);

}  // namespace magimu
