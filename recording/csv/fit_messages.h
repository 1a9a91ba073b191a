// SPDX-License-Identifier: BSD-3-Clause
// The CSV file that Garmin's FitCSVTool makes of a FIT file: one message a row, each field in three
// cells (name, value, unit). A sensor's message holds several samples, with bars between them
// ("0|40|80"). The messages and fields are those of Garmin's published profile.
#pragma once

#include <string>
#include <string_view>

#include "recording/csv/csv.h"

namespace magimu {

// Does a file with this beginning come from FitCSVTool?
bool is_fit_messages(std::string_view head);

// Throws InputError where no message is one of a sensor, and as csv_recording() does.
Recording read_fit_messages(const std::string& path, const CsvOptions& options);

}  // namespace magimu
