// SPDX-License-Identifier: BSD-3-Clause
// The files of a folder that is searched for recordings: each one once, however many links lead to
// it.
#pragma once

#include <string>
#include <vector>

namespace magimu {

// Paths of all files below the folder, sorted; a folder that is one recording (a phone's) stands
// for its files. Hidden ones are left out, and folders that magimu reprocess has written. Links are
// followed, after all that is there without them: a file that was found already, or a folder that
// was searched, does not count again. InputError where the folder cannot be read.
std::vector<std::string> files_below(const std::string& folder);

// Did magimu reprocess write it?
bool is_reprocess_output(const std::string& folder);

}  // namespace magimu
