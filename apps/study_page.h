// SPDX-License-Identifier: BSD-3-Clause
// The page of a study: verdict, then each experiment with what was found, figures, tables, checks.
#pragma once

#include <string>
#include <vector>

#include "study/study.h"

namespace magimu::apps {

std::string study_svg(const StudyFigure& figure);
std::string study_page(const std::vector<Study>& studies, const StudyOptions& options);

}  // namespace magimu::apps
