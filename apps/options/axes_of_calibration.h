// SPDX-License-Identifier: BSD-3-Clause
// A calibration holds for readings in the axes in which it was made. Its file says which turns of
// --axes came before it, and whoever uses it on another recording has to make the same.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/options/reading_options.h"

namespace magimu::apps {

// The field `axes` of a calibration's file: sensor to "y,-x,z".
nlohmann::ordered_json axes_json(const ReadingOptions& options);
// The same of the file of a calibration; empty where it has none.
std::map<std::string, std::string> axes_in(const std::string& path);
// InputError where a recording is to be read otherwise than those the file at `path` was made from.
// A file without the field (of the Python module, or older) is taken as it is.
void check_same_axes(const std::string& path, const ReadingOptions& options);

}  // namespace magimu::apps
