// SPDX-License-Identifier: BSD-3-Clause
// A recording before its calibration, as a page: `magimu info --report`.
#pragma once

#include <string>
#include <vector>

#include "calibration/survey/survey.h"
#include "recording/data/recording.h"

namespace magimu::apps {

struct SurveyedRecording {
  const Recording* recording = nullptr;
  Survey survey;
  std::string verdict;  // a sentence: survey_verdict()
};

std::string survey_page(const std::vector<SurveyedRecording>& all);

}  // namespace magimu::apps
