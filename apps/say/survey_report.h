// SPDX-License-Identifier: BSD-3-Clause
// What `magimu info` says of a recording: as people read it, and as JSON (docs/formats.md).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "calibration/survey/survey.h"

namespace magimu::apps {

// A sentence: may the recording be calibrated?
std::string survey_verdict(const Survey& survey);
std::string survey_text(const Survey& survey);
nlohmann::json survey_json(const Survey& survey, const std::vector<std::string>& notes);

}  // namespace magimu::apps
