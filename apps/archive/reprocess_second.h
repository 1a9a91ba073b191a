// SPDX-License-Identifier: BSD-3-Clause
// The second pass of an archive (archive/second_pass.h): where no recording of a device tells
// enough by itself, all of them together say where it is, and each is fitted there again; each of
// these fits in a process of its own.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/archive/reprocess_task.h"
#include "archive/fleet.h"

namespace magimu::apps {

// rows: their devices are known. tasks: of each result's name. Results are in folder/second, and
// rows get the paths of theirs. What has a result there is not done again. Forks, as run_tasks().
ReprocessRun second_pass(std::vector<FleetRecording>& rows,
                         const std::map<std::string, ReprocessTask>& tasks,
                         const std::string& folder, const ReprocessLimits& limits);

}  // namespace magimu::apps
