// SPDX-License-Identifier: BSD-3-Clause
// A calibration holds for readings in the axes in which it was made. Its file names the turns of
// --axes with which its recordings were read; another recording must be read with the same.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/options/reading_options.h"

namespace magimu::apps {

// The field `axes` of a calibration's file: sensor to "y,-x,z".
nlohmann::ordered_json axes_json(const ReadingOptions& options);
// The field `axes` of a calibration's file; empty if it has none.
std::map<std::string, std::string> axes_in(const nlohmann::ordered_json& file);
// Throws InputError if a recording is to be read with other turns than those of the calibration's
// file, which is at `path`. A file without the field (by the Python module, or older) is accepted.
void check_same_axes(const nlohmann::ordered_json& file, const std::string& path,
                     const ReadingOptions& options);

}  // namespace magimu::apps
