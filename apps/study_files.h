// SPDX-License-Identifier: BSD-3-Clause
// What `magimu study` writes, as text by the name of the file: a CSV file a table, an SVG file a
// figure, study.json and study.html with everything.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "study/study.h"

namespace magimu::apps {

std::map<std::string, std::string> study_files(const std::vector<Study>& studies,
                                               const StudyOptions& options);

// Throws InputError, with a remedy, where `folder` holds something else than an earlier study, so
// that no file of anybody's is lost; also where its parent is not there.
void check_study_folder(const std::string& folder);
// Whole or not at all: into a folder beside it, which then takes its place. An earlier study there
// is gone then.
void write_study_folder(const std::string& folder, const std::map<std::string, std::string>& files);

}  // namespace magimu::apps
